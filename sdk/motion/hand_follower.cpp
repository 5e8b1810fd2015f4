// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/hand_follower.h"

#include <algorithm>
#include <cmath>

#include "sdk/motion/limb.h"

namespace dpl {
namespace {

constexpr float kNeckShare = 0.5f;
constexpr float kLongest = 0.9999f;  // of a stretched arm: a bend that is not zero has a direction
const Quatf kHalfTurn(0, 0, 1, 0);   // about y: an avatar faces +z, a head looks along -z
constexpr float kLeast = 1e-6f;

struct FingerBone {
    const char *name, *next;  // without the side; next: the bone that it points to
    size_t tracked;           // XrHandJointEXT
};
constexpr FingerBone kFingerBones[] = {
    {"ThumbMetacarpal", "ThumbProximal", 2},      {"ThumbProximal", "ThumbDistal", 3},        {"ThumbDistal", "", 4},
    {"IndexProximal", "IndexIntermediate", 7},    {"IndexIntermediate", "IndexDistal", 8},    {"IndexDistal", "", 9},
    {"MiddleProximal", "MiddleIntermediate", 12}, {"MiddleIntermediate", "MiddleDistal", 13}, {"MiddleDistal", "", 14},
    {"RingProximal", "RingIntermediate", 17},     {"RingIntermediate", "RingDistal", 18},     {"RingDistal", "", 19},
    {"LittleProximal", "LittleIntermediate", 22}, {"LittleIntermediate", "LittleDistal", 23}, {"LittleDistal", "", 24},
};

int find(std::span<const JointData> joints, const std::string& bone) {
    const auto found = std::find_if(joints.begin(), joints.end(), [&](const JointData& joint) { return joint.humanoidBone == bone; });
    return found == joints.end() ? -1 : int(found - joints.begin());
}

Vec3f unit(const Vec3f& v, const Vec3f& otherwise = Vec3f(0)) {
    const float length = glm::length(v);
    return length > kLeast ? v / length : otherwise;
}

/** A part (0 to 1) of a rotation, the short way round. */
Quatf partOf(const Quatf& q, float part) {
    return glm::slerp(kNoTurn, q.w < 0 ? -q : q, part);
}

/** Of the bone at rest: to the next bone, else to a child, else on from its parent. */
Vec3f restDirection(std::span<const JointData> joints, size_t joint, int next) {
    const JointData& from = joints[joint];
    for (size_t j = joint + 1; j < joints.size() && next < 0; ++j)
        if (joints[j].parent == int32_t(joint)) next = int(j);
    if (next >= 0) return unit(joints[size_t(next)].restPosition - from.restPosition);
    return from.parent >= 0 ? unit(from.restPosition - joints[size_t(from.parent)].restPosition) : Vec3f(0);
}

}  // namespace

HandFollower::HandFollower(std::span<const JointData> joints)
    : joints_(joints), roles_(joints.size()), world_(joints.size()), place_(joints.size()) {
    for (size_t j = 0; j < joints.size(); ++j) {
        if (joints[j].humanoidBone == "neck") roles_[j].part = Part::Neck;
        if (joints[j].humanoidBone == "head") roles_[j].part = Part::Head;
    }
    for (size_t side = 0; side < 2; ++side) findArm(side);
}

void HandFollower::findArm(size_t side) {
    Arm& arm = arms_[side];
    const std::string s = side == 0 ? "left" : "right";
    const auto take = [&](const std::string& bone, Part part, const std::string& next) {
        const int joint = find(joints_, s + bone);
        if (joint < 0) return joint;
        Role& role = roles_[size_t(joint)];
        role.part = part, role.side = side;
        role.direction = restDirection(joints_, size_t(joint), find(joints_, s + next));
        return joint;
    };
    arm.upper = take("UpperArm", Part::UpperArm, "LowerArm"), arm.lower = take("LowerArm", Part::LowerArm, "Hand");
    arm.hand = take("Hand", Part::Hand, "MiddleProximal");
    for (const FingerBone& bone : kFingerBones)
        if (const int joint = take(bone.name, Part::Finger, bone.next); joint >= 0)
            roles_[size_t(joint)].tracked = handJoint(side, bone.tracked);
    if (arm.hand < 0) return;
    const Vec3f wrist = joints_[size_t(arm.hand)].restPosition;
    if (arm.upper >= 0 && arm.lower > arm.upper && arm.hand > arm.lower) {
        arm.upperM = glm::length(joints_[size_t(arm.lower)].restPosition - joints_[size_t(arm.upper)].restPosition);
        arm.lowerM = glm::length(wrist - joints_[size_t(arm.lower)].restPosition);
    }
    const int index = find(joints_, s + "IndexProximal"), middle = find(joints_, s + "MiddleProximal"),
              little = find(joints_, s + "LittleProximal");
    if (index < 0 || middle < 0 || little < 0) return;
    const auto fromWrist = [&](int joint) { return joints_[size_t(joint)].restPosition - wrist; };
    const Vec3f across = glm::cross(fromWrist(index), fromWrist(little)), back = unit((side == 0 ? 1.0f : -1.0f) * across);
    const Vec3f z = unit(-fromWrist(middle)), y = unit(back - glm::dot(back, z) * z);
    arm.knowsHand = glm::length(y) > 0.5f && glm::length(z) > 0.5f;
    if (arm.knowsHand) arm.restHand = glm::normalize(glm::quat_cast(Mat3f(glm::cross(y, z), y, z)));
}

void HandFollower::pose(const HeadAndHands& person, Pose& pose, std::span<uint8_t> driven) {
    for (size_t j = 0; j < roles_.size(); ++j) {
        const int32_t above = joints_[j].parent;
        const Quatf parent = above < 0 ? kNoTurn : world_[size_t(above)];
        place_[j] = above < 0 ? joints_[j].restPosition + (j == 0 ? pose.rootTranslation : Vec3f(0))
                              : place_[size_t(above)] + parent * (joints_[j].restPosition - joints_[size_t(above)].restPosition);
        world_[j] = glm::normalize(parent * pose.localRotations[j]);
        if (!follow(person, j, parent, world_[j])) continue;
        driven[j] = 1;
        pose.localRotations[j] = glm::normalize(glm::conjugate(parent) * world_[j]);
    }
}

/** Writes the rotation of a joint since rest if the person drives it. world: as the pose beneath has it. */
bool HandFollower::follow(const HeadAndHands& person, size_t joint, const Quatf& parentWorld, Quatf& world) {
    const Role& role = roles_[joint];
    Arm& arm = arms_[role.side];
    const size_t wrist = handJoint(role.side, kWrist);
    const bool hasWrist = person.tracked[wrist] != 0;
    switch (role.part) {
        case Part::None:
            return false;
        case Part::Neck:
        case Part::Head: {
            if (!person.tracked[0]) return false;
            const Quatf head = person.rotations[0] * kHalfTurn;
            world = role.part == Part::Head ? head : partOf(head * glm::conjugate(world), kNeckShare) * world;
            return true;
        }
        case Part::UpperArm:
            arm.reaches = hasWrist && reach(person, role.side, place_[joint], parentWorld, world);
            return arm.reaches;
        case Part::LowerArm:
            if (arm.reaches) world = arm.lowerWorld;
            return arm.reaches;
        case Part::Hand:
            if (!hasWrist || !arm.knowsHand) return false;
            world = person.rotations[wrist] * glm::conjugate(arm.restHand);
            return true;
        case Part::Finger: {
            if (!hasWrist || !arm.knowsHand || !person.tracked[role.tracked] || glm::length(role.direction) < 0.5f) return false;
            world = shortestTurn(parentWorld * role.direction, person.rotations[role.tracked] * Vec3f(0, 0, -1)) * parentWorld;
            return true;
        }
    }
    return false;
}

/** Bends the arm so that its end lies at the wrist. False: the avatar lacks a joint, or the wrist is in the shoulder. */
bool HandFollower::reach(const HeadAndHands& person, size_t side, const Vec3f& shoulder, const Quatf& torso, Quatf& upperWorld) {
    Arm& arm = arms_[side];
    const float a = arm.upperM, b = arm.lowerM;
    const size_t wrist = handJoint(side, kWrist);
    const Vec3f there = person.positions[wrist] - shoulder, towards = unit(there);
    if (a <= 0 || b <= 0 || glm::length(towards) < 0.5f) return false;
    const float distance = std::clamp(glm::length(there), std::abs(a - b) + 1e-4f, kLongest * (a + b));
    const Vec3f elbowSide = torso * Vec3f(side == 0 ? 0.4f : -0.4f, -1, -0.3f);
    const Vec3f back = torso * Vec3f(0, 0, -1);  // for a wrist that lies just where the elbow would go
    const Vec3f out = unit(elbowSide - glm::dot(elbowSide, towards) * towards, unit(back - glm::dot(back, towards) * towards));
    const float along = (a * a + distance * distance - b * b) / (2 * distance), aside = std::sqrt(std::max(0.0f, a * a - along * along));
    const Vec3f elbow = along * towards + aside * out;  // from the shoulder
    const Vec3f upperRest = roles_[size_t(arm.upper)].direction, lowerRest = roles_[size_t(arm.lower)].direction;
    upperWorld = glm::normalize(shortestTurn(torso * upperRest, elbow) * torso);
    arm.lowerWorld = shortestTurn(upperWorld * lowerRest, distance * towards - elbow) * upperWorld;
    if (arm.knowsHand) {
        const Quatf bend = glm::conjugate(arm.lowerWorld) * person.rotations[wrist] * glm::conjugate(arm.restHand);
        const float sine = glm::dot(Vec3f(bend.x, bend.y, bend.z), lowerRest);  // the part of the bend about the lower arm
        const Quatf twist(bend.w, sine * lowerRest.x, sine * lowerRest.y, sine * lowerRest.z);
        if (glm::length(twist) > kLeast) arm.lowerWorld = arm.lowerWorld * partOf(glm::normalize(twist), kWristTwistShare);
    }
    arm.lowerWorld = glm::normalize(arm.lowerWorld);
    return true;
}

}  // namespace dpl
