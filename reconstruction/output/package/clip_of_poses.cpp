// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/clip_of_poses.h"

#include <algorithm>

namespace dpl {

ClipData clipOfPoses(std::string name, std::vector<float> timesS, std::span<const Pose> poses) {
    ClipData clip;
    clip.name = std::move(name);
    clip.timesS = std::move(timesS);
    clip.channels.resize(poses.front().localRotations.size());
    for (size_t j = 0; j < clip.channels.size(); ++j) clip.channels[j].joint = uint32_t(j);
    for (const Pose& pose : poses) {
        clip.rootTranslations.push_back(pose.rootTranslation);
        for (size_t j = 0; j < clip.channels.size(); ++j) {
            Quatf q = glm::normalize(pose.localRotations[j]);
            auto& keys = clip.channels[j].rotations;
            if (!keys.empty() && glm::dot(keys.back(), q) < 0) q = -q;
            keys.push_back(q);
        }
    }
    std::erase_if(clip.channels, [](const ClipChannel& channel) {
        return std::all_of(channel.rotations.begin(), channel.rotations.end(),
                           [](const Quatf& q) { return glm::length(Vec3f(q.x, q.y, q.z)) < 1e-6f; });
    });
    return clip;
}

}  // namespace dpl
