// SPDX-License-Identifier: Apache-2.0
// Turns the result of training into an avatar, as a reader of its file decodes it.
#pragma once

#include <nlohmann/json.hpp>

#include "reconstruction/run/train_frames.h"
#include "reconstruction/subject/body/body_model.h"
#include "reconstruction/subject/garments/clothed_mesh.h"
#include "reconstruction/training/trainer/co_optimise.h"
#include "sdk/format/avatar_file.h"

namespace dpl {

/** How a finished avatar is written: as small as it gets without loss. */
inline constexpr WriteOptions kPackaged{.shPalette = true, .compact = true};

struct AssembledAvatar {
    AvatarData avatar;                   // decoded; its splats are bound to the decoded vertices
    std::vector<TrainFrame> frames;      // training frames with trained poses
    std::vector<uint8_t> triangleLabel;  // of the avatar's triangles, as in ClothedMesh
};

/** The trained avatar after one encoding and decoding, with its splats re-based onto the decoded mesh and its SH as a palette (write it
 *  with kPackaged). It has no evidence rows. `clothed` holds the layers before training, `set` the training frames. */
Result<AssembledAvatar> assembleAvatar(const std::vector<JointData>& joints, const ClothedMesh& clothed, const CoOptimiseResult& trained,
                                       const Scan& scan, FrameSet set, Jobs& jobs);

/** The constants that assembleAvatar() depends on besides its arguments, as part of a stage's key. */
nlohmann::json assembleInputs();

}  // namespace dpl
