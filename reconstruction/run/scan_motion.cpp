// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/scan_motion.h"

#include <algorithm>
#include <utility>

namespace dpl {

std::vector<ClipData> scanMotion(const Scan& scan, std::span<const size_t> frames, std::span<const Pose> poses) {
    std::vector<std::pair<double, size_t>> order;
    for (size_t i = 0; i < frames.size(); ++i) {
        const ScanFrame& frame = scan.frames[frames[i]];
        if (frame.kind == FrameKind::Dynamic) order.emplace_back(frame.timeS, i);
    }
    std::sort(order.begin(), order.end());
    order.erase(std::unique(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first == b.first; }), order.end());
    if (order.size() < 2) return {};
    ClipData clip;
    clip.name = "scan-motion";
    clip.channels.resize(poses.front().localRotations.size());
    for (size_t j = 0; j < clip.channels.size(); ++j) clip.channels[j].joint = uint32_t(j);
    for (const auto& [time, i] : order) {
        clip.timesS.push_back(float(time - order.front().first));
        clip.rootTranslations.push_back(poses[i].rootTranslation);
        for (size_t j = 0; j < clip.channels.size(); ++j) {
            Quatf q = glm::normalize(poses[i].localRotations[j]);
            auto& keys = clip.channels[j].rotations;
            if (!keys.empty() && glm::dot(keys.back(), q) < 0) q = -q;
            keys.push_back(q);
        }
    }
    std::erase_if(clip.channels, [](const ClipChannel& channel) {
        return std::all_of(channel.rotations.begin(), channel.rotations.end(),
                           [](const Quatf& q) { return glm::length(Vec3f(q.x, q.y, q.z)) < 1e-6f; });
    });
    return {clip};
}

}  // namespace dpl
