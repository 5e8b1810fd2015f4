// SPDX-License-Identifier: Apache-2.0
// An avatar that follows a tracked user: head and neck, arms, wrists and fingers.
//
// What a user shows and how the avatar's joints (VRM humanoid bones) follow; W is the rotation of a joint since its rest pose:
//
//   head               W(head) = rotation of the user's head; the neck takes half of the way there
//   wrist, pose        W(hand) = rotation from the hand at rest to the wrist. The hand at rest: -z from the hand to the knuckle of the
//   middle
//                      finger, y out of the back of the hand, which is the plane through the wrist and the knuckles of index and little
//   wrist, position    the arm reaches for it: upper and lower arm turn by the least, with the elbow down, out and a little back. A wrist
//                      out of reach is pointed at. The lower arm takes half of the wrist's twist
//   finger joint       the bone gets the direction of the tracked bone, turned with the hand by the least
//
// Only directions are taken from fingers, so bones of any length and any rest pose do. The avatar keeps its own build and its feet.
// A joint that is not located, or not in the avatar, keeps the pose of the clip; fingers and arms need a located wrist.
#pragma once

#include <doppel/doppel.hpp>
#include <string>
#include <vector>

#include "platform/openxr/user.h"

namespace dpl::xr {

class Puppet {
public:
    /** A joint of an avatar, as DplJointInfo has it. Parents come before their children. */
    struct Joint {
        int parent = -1;
        XrVector3f rest{0, 0, 0};  // metres, avatar space
        std::string bone;          // VRM humanoid name, or ""
    };

    explicit Puppet(std::span<const Joint> joints);
    /** The puppet of an avatar. General splats have no joints, and nothing of them is driven. */
    static doppel::Result<Puppet> of(DplAvatar avatar);

    size_t jointCount() const { return roles_.size(); }

    /** Turns the pose of a clip into the user's, joint by joint. Allocates nothing.
     *  user: in avatar space. withHead: head and neck follow too.
     *  rotations: a local rotation for each joint, as dplGetPose gives them. rootTranslation: metres.
     *  driven: for each joint, whether it now follows the user. */
    void pose(const User& user, bool withHead, std::span<XrQuaternionf> rotations, const XrVector3f& rootTranslation,
              std::span<uint8_t> driven);

private:
    enum class Part : uint8_t { None, Neck, Head, UpperArm, LowerArm, Hand, Finger };
    struct Role {
        Part part = Part::None;
        int side = 0;          // 0: left, 1: right
        uint32_t tracked = 0;  // XrHandJointEXT of a finger
        int parent = -1;
        XrVector3f fromParent{0, 0, 0};  // at rest, metres
        XrVector3f direction{0, 0, 0};   // of the bone at rest, unit; zero: unknown
    };
    struct Arm {
        int upper = -1, lower = -1, hand = -1;  // -1: the avatar has no such joint
        float upperM = 0, lowerM = 0;
        bool knowsHand = false;
        XrQuaternionf restHand{0, 0, 0, 1};    // axes of the hand at rest, as those of OpenXR's wrist
        bool reaches = false;                  // in the pose that is being made
        XrQuaternionf lowerWorld{0, 0, 0, 1};  // as above, of the lower arm
    };
    void findArm(std::span<const Joint> joints, int side);
    bool reach(const Hand& hand, int side, const XrVector3f& shoulder, const XrQuaternionf& torso, XrQuaternionf& upperWorld);
    bool follow(const User& user, bool withHead, size_t joint, const XrQuaternionf& parentWorld, XrQuaternionf& world);

    std::vector<Role> roles_;           // by joint
    Arm arms_[2];                       // left, right
    std::vector<XrQuaternionf> world_;  // of the pose that is being made, since rest
    std::vector<XrVector3f> place_;     // as above, avatar space
};

}  // namespace dpl::xr
