// SPDX-License-Identifier: Apache-2.0
// Turns the result of training into an avatar, as a reader of its file decodes it. Without files: it is made when a stage looks at it.
#pragma once

#include "reconstruction/input/capture/train_frame.h"
#include "reconstruction/run/graph.h"
#include "sdk/format/avatar_file.h"

namespace dpl {

/** How a finished avatar is written: as small as it gets without loss. */
inline constexpr WriteOptions kPackaged{.shPalette = true, .compact = true};

/** The trained avatar after one encoding and decoding, with its splats re-based onto the decoded mesh and its SH as a palette (write it
 *  with kPackaged). It has no evidence rows. */
struct AssembledAvatar {
    AvatarData avatar;                   // decoded; its splats are bound to the decoded vertices
    std::vector<TrainFrame> frames;      // training frames with trained poses
    std::vector<uint8_t> triangleLabel;  // of the avatar's triangles, as in ClothedMesh
};

template <>
struct StageOf<AssembledAvatar> {
    static constexpr StageName kName{"assemble", 4};
    static constexpr const char* kPriors[] = {"input/cameras",   "input/capture",        "subject/garments",
                                              "subject/surface", "training/correctives", "training/trainer"};
    static Status inputs(StageInputs& in);
    static Result<AssembledAvatar> compute(StageInputs& in);
};

/** Evens the weights of garments that training has torn, as it shortens edges. On a decoded mesh: then the file loads as it is written.
 * What a reader would mend once more is mended up to three times. Takes up to seconds of a core. */
void mendGarments(AvatarData& avatar);

/** The avatar as every reader decodes it, with its SH in a palette. */
Result<AvatarData> asReadersDecode(const AvatarData& avatar, Jobs& jobs);

}  // namespace dpl
