// SPDX-License-Identifier: Apache-2.0
// A motion file as a clip of an avatar, in one step.
#pragma once

#include "sdk/motion/retarget.h"

namespace dpl {

/** Reads a motion (readMotion) and retargets it (retarget). What was chosen, left out or is lacking goes to the log, a warning each, after
 *  `name`. Errors of both. */
Result<ClipData> readClip(std::span<const uint8_t> bytes, std::string_view name, const MotionChoice& choice,
                          std::span<const JointData> target, RetargetOptions options = {});

}  // namespace dpl
