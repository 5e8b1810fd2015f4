// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/puppet.h"

#include <algorithm>

#include "platform/openxr/rotations.h"

namespace dpl::xr {
namespace {

constexpr const char* kSides[] = {"left", "right"};
constexpr float kNeckShare = 0.5f, kTwistShare = 0.5f;
constexpr float kLongest = 0.9999f;             // of a stretched arm: a bend that is not zero has a direction
constexpr XrQuaternionf kHalfTurn{0, 1, 0, 0};  // about y: an avatar faces +z, a head looks along -z

struct FingerBone {
    const char *name, *next;  // without the side; next: the bone that it points to
    XrHandJointEXT tracked;
};
constexpr FingerBone kFingerBones[] = {
    {"ThumbMetacarpal", "ThumbProximal", XR_HAND_JOINT_THUMB_METACARPAL_EXT},
    {"ThumbProximal", "ThumbDistal", XR_HAND_JOINT_THUMB_PROXIMAL_EXT},
    {"ThumbDistal", "", XR_HAND_JOINT_THUMB_DISTAL_EXT},
    {"IndexProximal", "IndexIntermediate", XR_HAND_JOINT_INDEX_PROXIMAL_EXT},
    {"IndexIntermediate", "IndexDistal", XR_HAND_JOINT_INDEX_INTERMEDIATE_EXT},
    {"IndexDistal", "", XR_HAND_JOINT_INDEX_DISTAL_EXT},
    {"MiddleProximal", "MiddleIntermediate", XR_HAND_JOINT_MIDDLE_PROXIMAL_EXT},
    {"MiddleIntermediate", "MiddleDistal", XR_HAND_JOINT_MIDDLE_INTERMEDIATE_EXT},
    {"MiddleDistal", "", XR_HAND_JOINT_MIDDLE_DISTAL_EXT},
    {"RingProximal", "RingIntermediate", XR_HAND_JOINT_RING_PROXIMAL_EXT},
    {"RingIntermediate", "RingDistal", XR_HAND_JOINT_RING_INTERMEDIATE_EXT},
    {"RingDistal", "", XR_HAND_JOINT_RING_DISTAL_EXT},
    {"LittleProximal", "LittleIntermediate", XR_HAND_JOINT_LITTLE_PROXIMAL_EXT},
    {"LittleIntermediate", "LittleDistal", XR_HAND_JOINT_LITTLE_INTERMEDIATE_EXT},
    {"LittleDistal", "", XR_HAND_JOINT_LITTLE_DISTAL_EXT},
};

int find(std::span<const Puppet::Joint> joints, const std::string& bone) {
    const auto found = std::find_if(joints.begin(), joints.end(), [&](const Puppet::Joint& joint) { return joint.bone == bone; });
    return found == joints.end() ? -1 : int(found - joints.begin());
}

/** Of the bone at rest: to the next bone, else to a child, else on from its parent. */
XrVector3f restDirection(std::span<const Puppet::Joint> joints, int joint, int next) {
    const Puppet::Joint& from = joints[size_t(joint)];
    for (size_t j = size_t(joint) + 1; j < joints.size() && next < 0; ++j)
        if (joints[j].parent == joint) next = int(j);
    if (next >= 0) return normalised(joints[size_t(next)].rest - from.rest);
    return from.parent >= 0 ? normalised(from.rest - joints[size_t(from.parent)].rest) : XrVector3f{0, 0, 0};
}

}  // namespace

Puppet::Puppet(std::span<const Joint> joints) : roles_(joints.size()), world_(joints.size()), place_(joints.size()) {
    for (size_t j = 0; j < joints.size(); ++j) {
        const int parent = joints[j].parent;
        roles_[j].parent = parent;
        roles_[j].fromParent = parent < 0 ? joints[j].rest : joints[j].rest - joints[size_t(parent)].rest;
        if (joints[j].bone == "neck") roles_[j].part = Part::Neck;
        if (joints[j].bone == "head") roles_[j].part = Part::Head;
    }
    for (int side = 0; side < 2; ++side) findArm(joints, side);
}

doppel::Result<Puppet> Puppet::of(DplAvatar avatar) {
    const auto info = doppel::filled<DplAvatarInfo>(dplGetAvatarInfo, avatar);
    if (!info) return info.error();
    std::vector<Joint> joints(info->jointCount);
    for (uint32_t j = 0; j < info->jointCount; ++j) {
        const auto joint = doppel::filled<DplJointInfo>(dplGetJointInfo, avatar, j);
        if (!joint) return joint.error();
        joints[j] = {joint->parent, {joint->restPosition[0], joint->restPosition[1], joint->restPosition[2]}, joint->humanoidBone};
    }
    return Puppet(joints);
}

void Puppet::findArm(std::span<const Joint> joints, int side) {
    const std::string left = kSides[side];
    Arm& arm = arms_[side];
    const auto take = [&](const char* name, Part part, const std::string& next) {
        const int joint = find(joints, left + name);
        if (joint >= 0) roles_[size_t(joint)].part = part, roles_[size_t(joint)].side = side;
        if (joint >= 0) roles_[size_t(joint)].direction = restDirection(joints, joint, find(joints, left + next));
        return joint;
    };
    arm.upper = take("UpperArm", Part::UpperArm, "LowerArm"), arm.lower = take("LowerArm", Part::LowerArm, "Hand");
    arm.hand = take("Hand", Part::Hand, "MiddleProximal");
    for (const FingerBone& bone : kFingerBones)
        if (const int joint = take(bone.name, Part::Finger, bone.next); joint >= 0) roles_[size_t(joint)].tracked = bone.tracked;
    if (arm.hand < 0) return;
    const XrVector3f wrist = joints[size_t(arm.hand)].rest;
    if (arm.upper >= 0 && arm.lower > arm.upper && arm.hand > arm.lower) {
        arm.upperM = length(joints[size_t(arm.lower)].rest - joints[size_t(arm.upper)].rest);
        arm.lowerM = length(wrist - joints[size_t(arm.lower)].rest);
    }
    const int index = find(joints, left + "IndexProximal"), middle = find(joints, left + "MiddleProximal"),
              little = find(joints, left + "LittleProximal");
    if (index < 0 || middle < 0 || little < 0) return;
    const auto fromWrist = [&](int joint) { return joints[size_t(joint)].rest - wrist; };
    const XrVector3f across = cross(fromWrist(index), fromWrist(little)), back = normalised((side == 0 ? 1.0f : -1.0f) * across);
    const XrVector3f z = normalised(-1.0f * fromWrist(middle)), y = normalised(back - dot(back, z) * z);
    arm.knowsHand = length(y) > 0.5f && length(z) > 0.5f;
    if (arm.knowsHand) arm.restHand = fromAxes(cross(y, z), y, z);
}

void Puppet::pose(const User& user, bool withHead, std::span<XrQuaternionf> rotations, const XrVector3f& rootTranslation,
                  std::span<uint8_t> driven) {
    for (size_t j = 0; j < roles_.size(); ++j) {
        const Role& role = roles_[j];
        const XrQuaternionf parent = role.parent < 0 ? XrQuaternionf{0, 0, 0, 1} : world_[size_t(role.parent)];
        place_[j] = role.parent < 0 ? role.fromParent + rootTranslation : place_[size_t(role.parent)] + rotate(parent, role.fromParent);
        world_[j] = parent * rotations[j];
        driven[j] = follow(user, withHead, j, parent, world_[j]);
        if (driven[j]) rotations[j] = normalised(conjugate(parent) * world_[j]);
    }
}

/** Writes the rotation of a joint since rest if the user drives it. world: as the clip has it. */
bool Puppet::follow(const User& user, bool withHead, size_t joint, const XrQuaternionf& parentWorld, XrQuaternionf& world) {
    const Role& role = roles_[joint];
    const Hand& hand = user.hands[role.side];
    Arm& arm = arms_[role.side];
    const bool hasWrist = hand.has(XR_HAND_JOINT_WRIST_EXT);
    switch (role.part) {
        case Part::None:
            return false;
        case Part::Neck:
        case Part::Head: {
            if (!withHead) return false;
            const XrQuaternionf head = user.head.orientation * kHalfTurn;
            world = role.part == Part::Head ? head : partOf(head * conjugate(world), kNeckShare) * world;
            return true;
        }
        case Part::UpperArm:
            arm.reaches = hasWrist && reach(hand, role.side, place_[joint], parentWorld, world);
            return arm.reaches;
        case Part::LowerArm:
            if (arm.reaches) world = arm.lowerWorld;
            return arm.reaches;
        case Part::Hand:
            if (!hasWrist || !arm.knowsHand) return false;
            world = hand.joints[XR_HAND_JOINT_WRIST_EXT].orientation * conjugate(arm.restHand);
            return true;
        case Part::Finger: {
            if (!hasWrist || !arm.knowsHand || !hand.has(role.tracked) || length(role.direction) < 0.5f) return false;
            const XrVector3f wanted = rotate(hand.joints[role.tracked].orientation, {0, 0, -1});
            world = between(rotate(parentWorld, role.direction), wanted) * parentWorld;
            return true;
        }
    }
    return false;
}

/** Bends the arm so that its end lies at the wrist. False: the avatar lacks a joint, or the wrist is in the shoulder. */
bool Puppet::reach(const Hand& hand, int side, const XrVector3f& shoulder, const XrQuaternionf& torso, XrQuaternionf& upperWorld) {
    Arm& arm = arms_[side];
    const float a = arm.upperM, b = arm.lowerM;
    const XrPosef& wrist = hand.joints[XR_HAND_JOINT_WRIST_EXT];
    const XrVector3f there = wrist.position - shoulder, towards = normalised(there);
    if (a <= 0 || b <= 0 || length(towards) < 0.5f) return false;
    const float distance = std::clamp(length(there), std::abs(a - b) + 1e-4f, kLongest * (a + b));
    const XrVector3f elbowSide = rotate(torso, {side == 0 ? 0.4f : -0.4f, -1, -0.3f});
    const XrVector3f back = rotate(torso, {0, 0, -1});  // for a wrist that lies just where the elbow would go
    const XrVector3f out = normalised(elbowSide - dot(elbowSide, towards) * towards, normalised(back - dot(back, towards) * towards));
    const float along = (a * a + distance * distance - b * b) / (2 * distance), aside = std::sqrt(std::max(0.0f, a * a - along * along));
    const XrVector3f elbow = along * towards + aside * out;  // from the shoulder
    const XrVector3f upperRest = roles_[size_t(arm.upper)].direction, lowerRest = roles_[size_t(arm.lower)].direction;
    upperWorld = between(rotate(torso, upperRest), normalised(elbow)) * torso;
    const XrVector3f lower = normalised(distance * towards - elbow);
    arm.lowerWorld = between(rotate(upperWorld, lowerRest), lower) * upperWorld;
    if (arm.knowsHand) {
        const XrQuaternionf bend = conjugate(arm.lowerWorld) * wrist.orientation * conjugate(arm.restHand);
        const float sine = dot({bend.x, bend.y, bend.z}, lowerRest);  // the part of the bend about the lower arm
        const XrQuaternionf twist = normalised(XrQuaternionf{sine * lowerRest.x, sine * lowerRest.y, sine * lowerRest.z, bend.w});
        arm.lowerWorld = arm.lowerWorld * partOf(twist, kTwistShare);
    }
    return true;
}

}  // namespace dpl::xr
