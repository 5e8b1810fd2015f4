// SPDX-License-Identifier: Apache-2.0
// Keeps arms out of the body. Formulas: docs/reference/driving.md.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sdk/avatar/body_shape.h"
#include "sdk/avatar/rig.h"

namespace dpl {

/** Elbow and wrist are each pushed by at most this. */
constexpr float kFarthestPushM = 0.15f;
/** Upper arms and ribs give way to each other: upper arm and elbow count with this share of their radius. */
constexpr float kFirmShare = 0.6f;

/** Moves arms out of the body, so that they touch it instead of cutting through: first the arm swings about the shoulder until upper arm
 *  and elbow are free, then the elbow bends until lower arm, palm and fingers are. Hands turn with the swing, and keep their rotation while
 *  the elbow bends. */
class ArmGuard {
public:
    /** body: of that rig. The joints must outlive this. An empty body guards nothing. */
    ArmGuard(BodyShape body, std::span<const JointData> joints);

    /** Whether the rig has this arm, and its upper joint. side: 0 left, 1 right. */
    std::optional<size_t> upperArm(size_t side) const {
        return arms_[side].wristBalls.empty() ? std::nullopt : std::optional(arms_[side].upper);
    }
    /** By how much elbow and wrist of an arm must move, metres, world. The elbow takes the wrist along; the wrist's push comes on top. */
    struct Push {
        Vec3f elbow{0}, wrist{0};

        bool none() const { return elbow == Vec3f(0) && wrist == Vec3f(0); }
    };
    using Pushes = std::array<Push, 2>;  // left, right
    /** The pose must have passed checkPose. */
    Pushes pushes(const Pose& pose);
    /** Moves the arms. Pushes of 0 change nothing. */
    void push(const Pushes& pushes, Pose& pose);

private:
    /** A ball of the arm: its centre is a point of a joint at rest, and moves by `share` of what elbow or wrist moves. */
    struct Ball {
        size_t joint = 0;
        Vec3f rest{0};
        float radiusM = 0, share = 1;
    };
    struct Arm {
        size_t upper = 0, lower = 0, hand = 0;
        std::vector<Ball> elbowBalls, wristBalls;  // none: the rig lacks the arm
    };
    Vec3f pushFor(std::span<const Ball> balls, const Vec3f& shoulder, const Quatf& swing) const;
    Quatf swingFor(const Arm& arm, const Vec3f& elbowPush) const;
    Vec3f jointAt(size_t joint) const;

    BodyShape body_;
    std::span<const JointData> joints_;
    std::array<Arm, 2> arms_;     // left, right
    std::vector<Mat3x4f> world_;  // of the pose that is being guarded
};

}  // namespace dpl
