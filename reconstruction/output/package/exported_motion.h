// SPDX-License-Identifier: Apache-2.0
// The motion of an export: a clip of the avatar or of a file, with what clothes remember of it, as programs play it.
#pragma once

#include <optional>
#include <string>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/motion/clip_memory.h"

namespace dpl {

class ExportedMotion {
public:
    /** clip: name of a clip of the avatar, or path of a BVH or glTF file, retargeted as dplLoadClip does; empty: the rest pose. animation:
     * of a glTF file. The avatar must outlive this. InvalidArgument and others: it is neither; the text names it. */
    ExportedMotion(const AvatarData& avatar) : avatar_(avatar) {}
    ExportedMotion(const ExportedMotion&) = delete;
    Status open(const std::string& clip, const std::string& animation);

    double durationS() const;
    /** The pose so many seconds after the start. Fastest where times rise. */
    Pose at(double timeS);
    const std::optional<ClipData>& clip() const { return clip_; }

private:
    const AvatarData& avatar_;
    std::optional<ClipData> clip_;  // none: the rest pose
    std::optional<ClipMemory> memory_;
};

}  // namespace dpl
