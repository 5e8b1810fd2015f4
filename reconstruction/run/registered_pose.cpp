// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/registered_pose.h"

namespace dpl {
namespace {

Quatf shorterSlerp(const Quatf& a, const Quatf& b, float t) {
    return glm::normalize(glm::slerp(a, glm::dot(a, b) < 0 ? -b : b, t));
}

}  // namespace

std::vector<const Pose*> trainedPoses(const FrameTable& table, const CoOptimiseResult& trained) {
    std::vector<const Pose*> byFrame(table.rows(), nullptr);
    size_t next = 0;
    for (size_t f = 0; f < byFrame.size() && next < trained.poses.size(); ++f)
        if (table.trains(f)) byFrame[f] = &trained.poses[next++];
    return byFrame;
}

Pose registeredPose(const Scan& scan, const std::vector<Pose>& untrained, const std::vector<const Pose*>& trained, size_t f) {
    const ScanFrame& frame = scan.frames[f];
    const Pose& fitted = untrained[f];
    const auto neighbour = [&](int step) -> long {
        for (long k = long(f) + step; k >= 0 && k < long(trained.size()); k += step)
            if (trained[size_t(k)] && scan.frames[size_t(k)].kind == frame.kind) return k;
        return -1;
    };
    long before = neighbour(-1), after = neighbour(+1);
    if (before < 0) before = after;
    if (after < 0) after = before;
    if (before < 0) return fitted;
    const float t = after == before ? 0.0f : float(long(f) - before) / float(after - before);
    const Pose &a = *trained[size_t(before)], &b = *trained[size_t(after)];
    Pose pose = fitted;
    if (frame.kind != FrameKind::Dynamic) {
        for (size_t j = 0; j < pose.localRotations.size(); ++j)
            pose.localRotations[j] = shorterSlerp(a.localRotations[j], b.localRotations[j], t);
        pose.rootTranslation = glm::mix(a.rootTranslation, b.rootTranslation, t);
        return pose;
    }
    const Pose &fitA = untrained[size_t(before)], &fitB = untrained[size_t(after)];
    for (size_t j = 0; j < pose.localRotations.size(); ++j) {
        const Quatf changeA = a.localRotations[j] * glm::inverse(fitA.localRotations[j]),
                    changeB = b.localRotations[j] * glm::inverse(fitB.localRotations[j]);
        pose.localRotations[j] = glm::normalize(shorterSlerp(changeA, changeB, t) * fitted.localRotations[j]);
    }
    pose.rootTranslation += glm::mix(a.rootTranslation - fitA.rootTranslation, b.rootTranslation - fitB.rootTranslation, t);
    return pose;
}

}  // namespace dpl
