// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/aimed_pose.h"

#include <cmath>
#include <string>
#include <tuple>

namespace dpl {
namespace {

Vec3f directionOf(const LimbAim& limb) {
    const float out = glm::radians(limb.outDegrees), forward = glm::radians(limb.forwardDegrees);
    return {std::sin(out), -std::cos(out) * std::cos(forward), std::cos(out) * std::sin(forward)};
}

/** Turns a bone so that its limb points along `direction`; the bones above it have turned by `above`. Returns the limb's own turn. */
Quatf aim(std::span<const JointData> joints, size_t bone, size_t next, const Vec3f& direction, const Quatf& above, Pose& pose) {
    const Vec3f limb = joints[next].restPosition - joints[bone].restPosition;
    if (!(glm::length(limb) > 1e-4f)) return above;
    const Quatf turn = Quatf(glm::normalize(limb), glm::normalize(direction));
    pose.localRotations[bone] = glm::normalize(glm::inverse(above) * turn);
    return turn;
}

}  // namespace

bool PoseAimer::known() const {
    for (const char* needed : {"hips", "leftUpperLeg", "rightUpperLeg"})
        if (!bones_.contains(needed)) return false;
    return true;
}

Pose PoseAimer::pose(const AimedPose& aimed) const {
    Pose pose = Pose::rest(joints_.size());
    if (const auto spine = findBone(bones_, "spine")) pose.localRotations[*spine] = Quatf(glm::radians(aimed.spineDegrees));
    for (const auto& [side, aims, mirror] : {std::tuple("left", &aimed.left, 1.0f), std::tuple("right", &aimed.right, -1.0f)}) {
        Quatf above(1, 0, 0, 0);
        for (const LimbAim& limb : *aims) {
            const auto bone = findBone(bones_, std::string(side) + limb.bone), next = findBone(bones_, std::string(side) + limb.next);
            if (!bone || !next) continue;
            if (!limb.follows) above = Quatf(1, 0, 0, 0);
            above = aim(joints_, *bone, *next, directionOf(limb) * Vec3f(mirror, 1, 1), above, pose);
        }
    }
    return pose;
}

}  // namespace dpl
