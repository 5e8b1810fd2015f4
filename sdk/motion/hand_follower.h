// SPDX-License-Identifier: Apache-2.0
// An avatar that follows a head and two hands: head and neck, arms, wrists and fingers.
//
// W is the rotation of a joint since its rest pose:
//
//   head               W(head) = rotation of the person's head; the neck takes half of the way there
//   wrist, pose        W(hand) = rotation from the hand at rest to the wrist. The hand at rest: -z from the hand to the knuckle of the
//   middle
//                      finger, y out of the back of the hand, which is the plane through the wrist and the knuckles of index and little
//   wrist, position    the arm reaches for it: upper and lower arm turn by the least, with the elbow down, out and a little back. A wrist
//                      out of reach is pointed at. The lower arm takes half of the wrist's twist
//   finger joint       the bone gets the direction of the tracked bone, turned with the hand by the least
//
// Only directions are taken from fingers, so bones of any length and any rest pose do. The avatar keeps its own build.
// A joint that is not tracked, or not in the avatar, keeps the pose beneath; fingers and arms need a tracked wrist.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/motion/track_format.h"

namespace dpl {

/** The 53 poses of TrackFormat::OpenxrHands. The -z of a hand's joint points along its bone to the finger tip, y out of the back of the
 *  hand; a head looks along -z, y up. */
struct HeadAndHands {
    static constexpr size_t kCount = 1 + 2 * kHandJoints;
    std::array<Quatf, kCount> rotations;
    std::array<Vec3f, kCount> positions;  // metres
    std::array<uint8_t, kCount> tracked{};
};

class HandFollower {
public:
    /** The joints must outlive this. */
    explicit HandFollower(std::span<const JointData> joints);

    /** Turns the pose beneath into the person's, joint by joint. Allocates nothing.
     *  person: in avatar space. driven: by joint, set to 1 where the joint now follows the person; others keep their value. */
    void pose(const HeadAndHands& person, Pose& pose, std::span<uint8_t> driven);

private:
    enum class Part : uint8_t { None, Neck, Head, UpperArm, LowerArm, Hand, Finger };
    struct Role {
        Part part = Part::None;
        size_t side = 0;     // 0: left, 1: right
        size_t tracked = 0;  // place in HeadAndHands of a finger
        Vec3f direction{0};  // of the bone at rest, unit; zero: unknown
    };
    struct Arm {
        int upper = -1, lower = -1, hand = -1;  // -1: the avatar has no such joint
        float upperM = 0, lowerM = 0;
        bool knowsHand = false;
        Quatf restHand{1, 0, 0, 0};    // axes of the hand at rest, as those of OpenXR's wrist
        bool reaches = false;          // in the pose that is being made
        Quatf lowerWorld{1, 0, 0, 0};  // as above, of the lower arm
    };
    void findArm(size_t side);
    bool reach(const HeadAndHands& person, size_t side, const Vec3f& shoulder, const Quatf& torso, Quatf& upperWorld);
    bool follow(const HeadAndHands& person, size_t joint, const Quatf& parentWorld, Quatf& world);

    std::span<const JointData> joints_;
    std::vector<Role> roles_;  // by joint
    std::array<Arm, 2> arms_;  // left, right
    std::vector<Quatf> world_;
    std::vector<Vec3f> place_;
};

}  // namespace dpl
