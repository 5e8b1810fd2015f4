// SPDX-License-Identifier: Apache-2.0
#include "sdk/motion/arm_guard.h"

#include <algorithm>
#include <cmath>

#include "sdk/avatar/humanoid.h"
#include "sdk/motion/limb.h"

namespace dpl {
namespace {

constexpr int kRounds = 4;
constexpr float kFingerShare = 0.65f;  // thickness of a finger over that of the palm
constexpr float kTouchM = 0.0005f;     // less than this deep is touching

}  // namespace

ArmGuard::ArmGuard(BodyShape body, std::span<const JointData> joints) : body_(std::move(body)), joints_(joints) {
    if (body_.empty()) return;
    const BoneMap bones = bonesOf(joints);
    for (size_t side = 0; side < 2; ++side) {
        const std::string s = side == 0 ? "left" : "right";
        const auto upper = findBone(bones, s + "UpperArm"), lower = findBone(bones, s + "LowerArm"), hand = findBone(bones, s + "Hand");
        if (!upper || !lower || !hand || joints[*upper].parent < 0 || joints[*hand].parent != int32_t(*lower) ||
            joints[*lower].parent != int32_t(*upper))
            continue;
        const Vec3f shoulder = joints[*upper].restPosition, elbow = joints[*lower].restPosition, wrist = joints[*hand].restPosition;
        Arm& arm = arms_[side];
        arm.upper = *upper, arm.lower = *lower, arm.hand = *hand;
        const float thickM = body_.handM(side);
        arm.elbowBalls = {{*lower, elbow, kFirmShare * body_.lowerArmM(side), 1},
                          {*upper, 0.5f * (shoulder + elbow), kFirmShare * body_.upperArmM(side), 0.5f}};
        arm.wristBalls = {{*hand, wrist, thickM, 1}, {*lower, 0.5f * (elbow + wrist), body_.lowerArmM(side), 0.7f}};
        for (const char* finger : {"Index", "Middle", "Little"}) {
            const auto proximal = findBone(bones, s + finger + "Proximal"), middle = findBone(bones, s + finger + "Intermediate"),
                       distal = findBone(bones, s + finger + "Distal");
            if (!proximal || !middle || !distal) continue;
            const Vec3f last = joints[*distal].restPosition;
            arm.wristBalls.push_back({*hand, joints[*proximal].restPosition, thickM, 1});
            arm.wristBalls.push_back({*proximal, joints[*middle].restPosition, kFingerShare * thickM, 1});
            arm.wristBalls.push_back({*distal, last + 0.5f * (last - joints[*middle].restPosition), kFingerShare * thickM, 1});
        }
    }
}

/** By how much a joint must move so that none of the balls lies in the body. `swing` has turned them about the shoulder. */
Vec3f ArmGuard::pushFor(std::span<const Ball> balls, const Vec3f& shoulder, const Quatf& swing) const {
    Vec3f push(0);
    for (int round = 0; round < kRounds; ++round) {
        float deepest = kTouchM;
        Vec3f step(0);
        for (const Ball& ball : balls) {
            const Vec3f unmoved = world_[ball.joint] * Vec4f(ball.rest, 1);
            const Vec3f centre = shoulder + swing * (unmoved - shoulder) + ball.share * push;
            const auto in = body_.inside(centre, ball.radiusM, world_);
            if (in && in->depthM > deepest) deepest = in->depthM, step = in->outward * (in->depthM / ball.share);
        }
        if (step == Vec3f(0)) break;
        push += step;
    }
    const float length = glm::length(push);
    return length > kFarthestPushM ? push * (kFarthestPushM / length) : push;
}

/** The turn about the shoulder that moves the elbow towards where it is pushed. */
Quatf ArmGuard::swingFor(const Arm& arm, const Vec3f& elbowPush) const {
    const Vec3f along = jointAt(arm.lower) - jointAt(arm.upper);
    return shortestTurn(along, along + elbowPush);
}

Vec3f ArmGuard::jointAt(size_t joint) const {
    return world_[joint] * Vec4f(joints_[joint].restPosition, 1);
}

ArmGuard::Pushes ArmGuard::pushes(const Pose& pose) {
    Pushes out{};
    if (body_.empty()) return out;
    jointTransforms(joints_, pose, world_);
    for (size_t side = 0; side < 2; ++side) {
        const Arm& arm = arms_[side];
        if (arm.wristBalls.empty()) continue;
        const Vec3f shoulder = jointAt(arm.upper);
        out[side].elbow = pushFor(arm.elbowBalls, shoulder, Quatf(1, 0, 0, 0));
        out[side].wrist = pushFor(arm.wristBalls, shoulder, swingFor(arm, out[side].elbow));
    }
    return out;
}

void ArmGuard::push(const Pushes& pushes, Pose& pose) {
    if (pushes[0].none() && pushes[1].none()) return;
    jointTransforms(joints_, pose, world_);
    for (size_t side = 0; side < 2; ++side) {
        const Arm& arm = arms_[side];
        if (arm.wristBalls.empty() || pushes[side].none()) continue;
        const auto turned = [&](size_t joint) { return glm::normalize(glm::quat_cast(Mat3f(world_[joint]))); };
        const Quatf above = turned(size_t(joints_[arm.upper].parent)), swing = swingFor(arm, pushes[side].elbow);
        const Vec3f shoulder = jointAt(arm.upper), out = above * Vec3f(side == 0 ? 1.0f : -1.0f, 0, -0.5f);
        const auto swung = [&](size_t joint) { return shoulder + swing * (jointAt(joint) - shoulder); };
        const Vec3f elbow = swung(arm.lower), wrist = swung(arm.hand);
        const auto turn = reachWith({shoulder, elbow, wrist}, wrist + pushes[side].wrist, out);
        const Quatf upper = turn[0] * swing * turned(arm.upper), lower = turn[1] * swing * turned(arm.lower);
        pose.localRotations[arm.upper] = glm::normalize(glm::conjugate(above) * upper);
        pose.localRotations[arm.lower] = glm::normalize(glm::conjugate(upper) * lower);
        pose.localRotations[arm.hand] = glm::normalize(glm::conjugate(lower) * swing * turned(arm.hand));
    }
}

}  // namespace dpl
