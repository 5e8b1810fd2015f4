// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/carried_pose.h"

#include "reconstruction/run/film_memory.h"

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

Pose carriedPose(const Scan& scan, const std::vector<Pose>& registered, const std::vector<const Pose*>& trained, size_t f) {
    const ScanFrame& frame = scan.frames[f];
    const Pose& own = registered[f];
    const auto neighbour = [&](int step) -> long {
        for (long k = long(f) + step; k >= 0 && k < long(trained.size()); k += step)
            if (trained[size_t(k)] && scan.frames[size_t(k)].kind == frame.kind) return k;
        return -1;
    };
    long before = neighbour(-1), after = neighbour(+1);
    if (before < 0) before = after;
    if (after < 0) after = before;
    if (before < 0) return own;
    const float t = after == before ? 0.0f : float(long(f) - before) / float(after - before);
    const Pose &a = *trained[size_t(before)], &b = *trained[size_t(after)];
    Pose pose = own;
    if (frame.kind != FrameKind::Dynamic) {
        for (size_t j = 0; j < pose.localRotations.size(); ++j)
            pose.localRotations[j] = shorterSlerp(a.localRotations[j], b.localRotations[j], t);
        pose.rootTranslation = glm::mix(a.rootTranslation, b.rootTranslation, t);
        return pose;
    }
    const Pose &untrainedA = registered[size_t(before)], &untrainedB = registered[size_t(after)];
    for (size_t j = 0; j < pose.localRotations.size(); ++j) {
        const Quatf changeA = a.localRotations[j] * glm::inverse(untrainedA.localRotations[j]),
                    changeB = b.localRotations[j] * glm::inverse(untrainedB.localRotations[j]);
        pose.localRotations[j] = glm::normalize(shorterSlerp(changeA, changeB, t) * own.localRotations[j]);
    }
    pose.rootTranslation += glm::mix(a.rootTranslation - untrainedA.rootTranslation, b.rootTranslation - untrainedB.rootTranslation, t);
    return pose;
}

std::vector<Pose> posesAfterTraining(const FrameTable& table, const std::vector<Pose>& registered, const CoOptimiseResult& trained,
                                     const MotionModeData& motion, HeldOut heldOut) {
    const std::vector<const Pose*> byFrame = trainedPoses(table, trained);
    std::vector<Pose> poses;
    for (size_t row = 0; row < table.rows(); ++row) {
        const bool trains = table.scan.frames[row].split == Split::Train;
        if (byFrame[row])
            poses.push_back(*byFrame[row]);
        else
            poses.push_back(trains ? registered[row] : carriedPose(table.scan, registered, byFrame, row));
    }
    std::vector<size_t> rows;
    std::vector<Pose> film;
    for (size_t row = 0; row < table.rows(); ++row)
        if (heldOut == HeldOut::Known || table.scan.frames[row].split != Split::Test) rows.push_back(row), film.push_back(poses[row]);
    rememberPoses(table.scan, rows, motion, film);
    for (size_t i = 0; i < rows.size(); ++i) poses[rows[i]].before = film[i].before;
    return poses;
}

}  // namespace dpl
