// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/clip.h"

#include <algorithm>
#include <cmath>

namespace dpl {

Status checkClip(const ClipData& clip, std::span<const JointData> joints) {
    const size_t keys = clip.timesS.size();
    if (keys == 0) return fail(Code::CorruptData, "clip '{}' has no keys", clip.name);
    for (size_t k = 0; k < keys; ++k)
        if (!std::isfinite(clip.timesS[k]) || (k > 0 && !(clip.timesS[k] > clip.timesS[k - 1])))
            return fail(Code::CorruptData, "the times of clip '{}' do not rise at key {}", clip.name, k);
    if (!clip.rootTranslations.empty() && clip.rootTranslations.size() != keys)
        return fail(Code::CorruptData, "clip '{}' has {} times and {} root translations", clip.name, keys, clip.rootTranslations.size());
    for (const Vec3f& t : clip.rootTranslations)
        if (!std::isfinite(t.x) || !std::isfinite(t.y) || !std::isfinite(t.z))
            return fail(Code::CorruptData, "a root translation of clip '{}' is not finite", clip.name);
    std::vector<bool> seen(joints.size(), false);
    for (const ClipChannel& channel : clip.channels) {
        if (channel.joint >= joints.size())
            return fail(Code::CorruptData, "clip '{}' moves joint {}; the rig has {}", clip.name, channel.joint, joints.size());
        const std::string& name = joints[channel.joint].name;
        if (seen[channel.joint]) return fail(Code::CorruptData, "clip '{}' moves joint '{}' twice", clip.name, name);
        seen[channel.joint] = true;
        if (channel.rotations.size() != keys)
            return fail(Code::CorruptData, "clip '{}' has {} times and {} rotations of joint '{}'", clip.name, keys,
                        channel.rotations.size(), name);
        for (size_t k = 0; k < keys; ++k) {
            const float norm2 = glm::dot(channel.rotations[k], channel.rotations[k]);
            if (!(norm2 > 1e-6f && norm2 < 1e6f))
                return fail(Code::CorruptData, "rotation {} of joint '{}' in clip '{}' is not a rotation", k, name, clip.name);
        }
    }
    return {};
}

double clipDurationS(const ClipData& clip) {
    return clip.timesS.empty() ? 0.0 : double(clip.timesS.back()) - double(clip.timesS.front());
}

double loopedTimeS(const ClipData& clip, double timeS) {
    const double durationS = clipDurationS(clip);
    return durationS > 0 ? timeS - std::floor(timeS / durationS) * durationS : 0.0;
}

Pose samplePose(const ClipData& clip, std::span<const JointData> joints, double timeS) {
    Pose pose;
    samplePose(clip, joints, timeS, pose);
    return pose;
}

void samplePose(const ClipData& clip, std::span<const JointData> joints, double timeS, Pose& pose) {
    pose.localRotations.assign(joints.size(), Quatf(1, 0, 0, 0));
    pose.rootTranslation = Vec3f(0);
    if (clip.timesS.empty()) return;
    const double t = double(clip.timesS.front()) + (std::isfinite(timeS) ? timeS : 0.0);
    const auto above = std::upper_bound(clip.timesS.begin(), clip.timesS.end(), t, [](double a, float b) { return a < double(b); });
    const size_t last = clip.timesS.size() - 1;
    const size_t k0 = above == clip.timesS.begin() ? 0 : size_t(above - clip.timesS.begin()) - 1, k1 = std::min(k0 + 1, last);
    const double t0 = clip.timesS[k0], t1 = clip.timesS[k1];
    const float f = t1 > t0 ? float(std::clamp((t - t0) / (t1 - t0), 0.0, 1.0)) : 0.0f;
    for (const ClipChannel& channel : clip.channels)
        pose.localRotations[channel.joint] =
            glm::normalize(glm::slerp(glm::normalize(channel.rotations[k0]), glm::normalize(channel.rotations[k1]), f));
    if (!clip.rootTranslations.empty()) pose.rootTranslation = glm::mix(clip.rootTranslations[k0], clip.rootTranslations[k1], f);
}

}  // namespace dpl
