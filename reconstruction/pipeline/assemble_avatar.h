// SPDX-License-Identifier: Apache-2.0
// From the result of training to an avatar as its readers will see it.
#pragma once

#include <nlohmann/json.hpp>

#include "reconstruction/body/body_model.h"
#include "reconstruction/pipeline/train_frames.h"
#include "reconstruction/splat/co_optimise.h"

namespace dpl {

struct AssembledAvatar {
    AvatarData avatar;               // decoded: splats are bound to the vertices that a reader gets
    std::vector<TrainFrame> frames;  // training frames with their trained poses
};

/** The trained avatar, encoded and decoded once, splats re-based onto the decoded mesh, SH as a palette (write it with
 *  WriteOptions::shPalette). No evidence rows yet. `shaped` is the body that was trained; `set` holds its training frames. */
Result<AssembledAvatar> assembleAvatar(const BodyModel& shaped, const CoOptimiseResult& trained, const Scan& scan, FrameSet set,
                                       Jobs& jobs);

/** The numbers that assembling depends on besides its arguments, for keys. */
nlohmann::json assembleInputs();

}  // namespace dpl
