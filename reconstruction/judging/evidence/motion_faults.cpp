// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/evidence/motion_faults.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/judging/report/flicker.h"
#include "reconstruction/subject/garments/cloth_faults.h"
#include "sdk/avatar/posed_mesh.h"

namespace dpl {
namespace {

constexpr double kStepRad = 0.02, kStepM = 0.01;  // 60 such steps a second turn a joint by 70 degrees a second

}  // namespace

Pose slowStep(const Pose& from, const Pose& to) {
    double share = 1;
    const auto limit = [&](double way, double most) {
        if (way > most) share = std::min(share, most / way);
    };
    std::vector<Quatf> aims = to.localRotations;
    for (size_t j = 0; j < aims.size(); ++j) {
        const double cosine = glm::dot(from.localRotations[j], aims[j]);
        if (cosine < 0) aims[j] = -aims[j];  // the shorter way
        limit(2 * std::acos(std::min(1.0, std::abs(cosine))), kStepRad);
    }
    limit(glm::length(to.rootTranslation - from.rootTranslation), kStepM);
    Pose pose = from;
    for (size_t j = 0; j < aims.size(); ++j)
        pose.localRotations[j] = glm::normalize(glm::slerp(from.localRotations[j], aims[j], float(share)));
    pose.rootTranslation = glm::mix(from.rootTranslation, to.rootTranslation, float(share));
    return pose;
}

Result<MotionFaults> motionFaults(const AvatarData& avatar, AvatarView& view, std::span<const TrainFrame> frames, Jobs& jobs) {
    std::vector<const TrainFrame*> moving;
    std::vector<Pose> poses;
    for (const TrainFrame& frame : frames)
        if (frame.kind == FrameKind::Dynamic) moving.push_back(&frame), poses.push_back(frame.pose);
    MotionFaults faults;
    faults.penetration = garmentPenetration(avatar, poses, jobs);
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    PosedMesh first, second;
    size_t sweeps = 0;
    for (size_t i = 0; i + 1 < poses.size(); ++i) {
        const Camerad& camera = moving[i]->camera;
        const Pose next = slowStep(poses[i], poses[i + 1]);
        first.pose({avatar.joints, avatar.mesh, avatar.correctives, bind}, poses[i], jobs);
        second.pose({avatar.joints, avatar.mesh, avatar.correctives, bind}, next, jobs);
        DPL_TRY(const auto shown, view.draw(poses[i], camera));
        DPL_TRY(const auto after, view.draw(next, camera));
        if (const auto levels = flickerLevels({shown, first.positions()}, {after, second.positions()}, avatar.mesh.triangles, camera))
            faults.flickerLevels += *levels, ++sweeps;
    }
    if (sweeps > 0) faults.flickerLevels /= double(sweeps);
    return faults;
}

}  // namespace dpl
