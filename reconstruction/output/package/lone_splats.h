// SPDX-License-Identifier: Apache-2.0
// Takes splats out of an avatar that draw specks beside the person: no picture asks for them, and every viewer sees them.
#pragma once

#include <span>

#include "reconstruction/input/capture/train_frame.h"
#include "sdk/core/jobs.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Draws the avatar in the still ones of `frames`, at the size of their pictures, and removes each splat that puts more than half of what
 * it shows in one of them into lone parts (subject/surface/lone_parts.h); again until none is left, at most a few rounds. Moving frames do
 *  not count: there a wrong pose may draw a whole hand beside the true one. The others keep their order. Returns how many were removed.
 *  Errors: a picture cannot be read; Cancelled. */
Result<uint32_t> dropLoneSplats(AvatarData& avatar, std::span<const TrainFrame> frames, Jobs& jobs);

}  // namespace dpl
