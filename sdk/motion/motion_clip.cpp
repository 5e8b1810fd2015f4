// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/motion_clip.h"

#include "sdk/core/log.h"

namespace dpl {

Result<ClipData> readClip(std::span<const uint8_t> bytes, std::string_view name, const MotionChoice& choice,
                          std::span<const JointData> target, RetargetOptions options) {
    DPL_TRY(Motion motion, readMotion(bytes, name, choice));
    options.notes = &motion.notes;
    DPL_TRY(ClipData clip, retarget(motion, target, options));
    for (const std::string& note : motion.notes) log(LogLevel::Warning, "{}: {}", name, note);
    return clip;
}

}  // namespace dpl
