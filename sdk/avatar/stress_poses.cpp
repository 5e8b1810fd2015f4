// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/stress_poses.h"

#include <cmath>
#include <map>
#include <string>
#include <tuple>

#include "sdk/avatar/humanoid.h"

namespace dpl {
namespace {

/** A limb that points somewhere, in the frame of the body at rest: x to the person's left, y up, z to the front. Left limbs are named;
 * their right twins take the mirrored direction. */
struct Aim {
    const char *bone, *next;  // the next bone down the limb
    Vec3f direction;
};

/** One pose: limbs of the left side, then of the right side as if it were the left one, and a turn of the spine. */
struct Stress {
    std::vector<Aim> left, right;
    Vec3f spineDegrees{0};  // about x, y, z
};

constexpr Aim thigh(float forwardDegrees, float outDegrees = 5) {
    return {"UpperLeg", "LowerLeg", {outDegrees, forwardDegrees, 0}};
}
constexpr Aim shank(float forwardDegrees) {
    return {"LowerLeg", "Foot", {5, forwardDegrees, 0}};
}
constexpr Aim arm(float forwardDegrees, float outDegrees) {
    return {"UpperArm", "LowerArm", {outDegrees, forwardDegrees, 0}};
}

/** Directions are given as degrees outwards and forwards from straight down. */
const std::vector<Stress> kStress = {
    {{thigh(40), shank(10), arm(-25, 12)}, {thigh(-25), shank(-45), arm(25, 12)}, {0, 10, 0}},  // a brisk step
    {{thigh(-25), shank(-45), arm(25, 12)}, {thigh(40), shank(10), arm(-25, 12)}, {0, -10, 0}},
    {{thigh(20), arm(-10, 12)}, {thigh(-15), arm(10, 12)}, {}},
    {{thigh(-15), arm(10, 12)}, {thigh(20), arm(-10, 12)}, {}},
    {{thigh(0, 25), arm(0, 90)}, {thigh(0, 25), arm(0, 90)}, {}},      // a wide stance, arms level
    {{thigh(30), arm(30, 15)}, {thigh(30), arm(30, 15)}, {25, 0, 0}},  // a bow
    {{arm(5, 3)}, {arm(5, 3)}, {}},                                    // arms that hang
    {{arm(80, 10)}, {arm(0, 12)}, {0, -20, 0}},                        // one hand forwards
    {{arm(0, 12)}, {arm(80, 10)}, {0, 20, 0}},
};

Vec3f downTurned(const Vec3f& outForward) {
    const float out = glm::radians(outForward.x), forward = glm::radians(outForward.y);
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

std::vector<Pose> stressPoses(std::span<const JointData> joints) {
    const std::vector<std::string> bones = humanoidBones(joints);
    std::map<std::string, size_t> jointOf;
    for (size_t j = 0; j < bones.size(); ++j)
        if (!bones[j].empty()) jointOf[bones[j]] = j;
    for (const char* needed : {"hips", "leftUpperLeg", "rightUpperLeg"})
        if (!jointOf.contains(needed)) return {};
    std::vector<Pose> poses;
    for (const Stress& stress : kStress) {
        Pose pose = Pose::rest(joints.size());
        if (const auto spine = jointOf.find("spine"); spine != jointOf.end())
            pose.localRotations[spine->second] = Quatf(glm::radians(stress.spineDegrees));
        for (const auto& [side, aims, mirror] : {std::tuple("left", &stress.left, 1.0f), std::tuple("right", &stress.right, -1.0f)}) {
            Quatf above(1, 0, 0, 0);
            for (const Aim& limb : *aims) {
                const auto bone = jointOf.find(std::string(side) + limb.bone), next = jointOf.find(std::string(side) + limb.next);
                if (bone == jointOf.end() || next == jointOf.end()) continue;
                if (std::string_view(limb.bone) != "LowerLeg") above = Quatf(1, 0, 0, 0);
                above = aim(joints, bone->second, next->second, downTurned(limb.direction) * Vec3f(mirror, 1, 1), above, pose);
            }
        }
        poses.push_back(std::move(pose));
    }
    return poses;
}

}  // namespace dpl
