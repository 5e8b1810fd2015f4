// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/scan_motion.h"

#include <algorithm>
#include <utility>

#include "reconstruction/output/package/clip_of_poses.h"

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
    std::vector<float> timesS;
    std::vector<Pose> moments;
    for (const auto& [time, i] : order) {
        timesS.push_back(float(time - order.front().first));
        moments.push_back(poses[i]);
    }
    return {clipOfPoses("scan-motion", std::move(timesS), moments)};
}

}  // namespace dpl
