// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/exported_motion.h"

#include <algorithm>
#include <filesystem>

#include "sdk/avatar/body_shape.h"
#include "sdk/core/files.h"
#include "sdk/motion/clip.h"
#include "sdk/motion/motion_clip.h"

namespace dpl {

Status ExportedMotion::open(const std::string& clip, const std::string& animation) {
    DPL_RETURN_IF_ERROR(checkRig(avatar_.joints));
    if (clip.empty()) return {};
    const auto own = std::find_if(avatar_.clips.begin(), avatar_.clips.end(), [&](const ClipData& c) { return c.name == clip; });
    if (own != avatar_.clips.end()) {
        clip_ = *own;
    } else {
        auto bytes = readFile(clip, uint64_t(512) << 20);
        if (!bytes) return fail(bytes.error().code, "--clip {} is neither a clip of the avatar nor a readable BVH or glTF file", clip);
        const BodyShape body = BodyShape::of(avatar_.joints, avatar_.mesh);
        RetargetOptions options;
        options.body = &body;
        auto read = readClip(*bytes, std::filesystem::path(clip).stem().string(), {animation}, avatar_.joints, options);
        if (!read) return fail(read.error().code, "--clip {}: {}", clip, read.error().message);
        clip_ = std::move(*read);
    }
    DPL_RETURN_IF_ERROR(checkClip(*clip_, avatar_.joints));
    memory_.emplace(*clip_, avatar_.joints, avatar_.correctives.motion);
    return {};
}

double ExportedMotion::durationS() const {
    return clip_ ? clipDurationS(*clip_) : 0;
}

Pose ExportedMotion::at(double timeS) {
    if (!clip_) return Pose::rest(avatar_.joints.size());
    Pose pose = samplePose(*clip_, avatar_.joints, timeS);
    pose.before = memory_->at(timeS, /*loop=*/false);
    return pose;
}

}  // namespace dpl
