// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/motion.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/sample/ease.h"
#include "reconstruction/subject/sample/random.h"
#include "reconstruction/subject/sample/skeleton.h"

namespace dpl {

SampleMotion SampleMotion::dynamicSequence(uint64_t seed, double durationS, bool fingers, bool headShake) {
    Random random(seed, 101);
    SampleMotion motion;
    motion.durationS_ = durationS;
    // Times below are for a duration of 18.75 s and are scaled to the wanted one.
    const double scale = durationS / 18.75;
    auto add = [&](uint8_t joint, Vec3d turn, double start, double rise, double hold, double fall) {
        const double amplitude = random.uniform(0.92, 1.08);
        motion.actions_.push_back({joint, turn * amplitude, start * scale, rise * scale, hold * scale, fall * scale});
    };
    // Arms out and up, one after the other, then both. A positive z turn raises the left arm.
    add(kLeftShoulder, {0, 0, 1.25}, 0.4, 1.0, 0.3, 0.9);
    add(kLeftCollar, {0, 0, 0.26}, 0.5, 0.9, 0.3, 0.8);
    add(kRightShoulder, {0, 0, -1.25}, 2.3, 1.0, 0.3, 0.9);
    add(kRightCollar, {0, 0, -0.26}, 2.4, 0.9, 0.3, 0.8);
    add(kLeftShoulder, {0, 0, 1.60}, 4.2, 1.1, 0.4, 1.0);
    add(kRightShoulder, {0, 0, -1.60}, 4.2, 1.1, 0.4, 1.0);
    add(kLeftCollar, {0, 0, 0.32}, 4.3, 1.0, 0.4, 0.9);
    add(kRightCollar, {0, 0, -0.32}, 4.3, 1.0, 0.4, 0.9);
    // A forward raise of the left arm with a bent elbow. A negative y turn brings the left arm forward.
    add(kLeftShoulder, {0, -1.25, 0.35}, 6.7, 0.8, 0.3, 0.8);
    add(kLeftElbow, {0, -0.9, 0}, 6.9, 0.8, 0.2, 0.7);
    // Both elbows, then the right one alone.
    add(kLeftElbow, {0, -1.45, 0.5}, 8.6, 0.7, 0.2, 0.7);
    add(kRightElbow, {0, 1.45, -0.5}, 8.6, 0.7, 0.2, 0.7);
    add(kRightShoulder, {0, 0.95, -0.2}, 10.2, 0.7, 0.2, 0.7);
    add(kRightElbow, {0, 1.55, 0}, 10.3, 0.7, 0.2, 0.6);
    // Left knee up, right knee up. A negative x turn lifts the thigh, a positive one bends the knee.
    add(kLeftHip, {-1.15, 0, 0.05}, 11.8, 0.7, 0.2, 0.7);
    add(kLeftKnee, {1.30, 0, 0}, 11.8, 0.7, 0.2, 0.7);
    add(kLeftAnkle, {0.25, 0, 0}, 11.9, 0.6, 0.2, 0.6);
    add(kRightShoulder, {0, 0, -0.30}, 11.8, 0.7, 0.2, 0.7);
    add(kRightHip, {-1.20, 0, -0.05}, 13.4, 0.7, 0.2, 0.7);
    add(kRightKnee, {1.35, 0, 0}, 13.4, 0.7, 0.2, 0.7);
    add(kRightAnkle, {0.25, 0, 0}, 13.5, 0.6, 0.2, 0.6);
    add(kLeftShoulder, {0, 0, 0.30}, 13.4, 0.7, 0.2, 0.7);
    // A turn left and right with a twist of the trunk, head leading.
    for (const auto& [joint, share] :
         {std::pair{kPelvis, 0.30}, {kSpine1, 0.12}, {kSpine2, 0.14}, {kSpine3, 0.14}, {kNeck, 0.16}, {kHead, 0.22}}) {
        add(joint, {0, share, 0}, 15.0, 0.7, 0.2, 0.7);
        add(joint, {0, -share, 0}, 16.6, 0.7, 0.2, 0.7);
    }
    add(kLeftShoulder, {0, 0.30, -0.25}, 15.0, 0.7, 0.2, 0.7);
    add(kRightShoulder, {0, 0.30, 0.25}, 15.0, 0.7, 0.2, 0.7);
    // Fingers curl and spread a little while the arms are up.
    const HandFrame hand = leftHandFrame();
    const Vec3d curl(hand.thumbward), curlRight(curl.x, -curl.y, -curl.z);
    for (int f = 0; f < kFingerCount - 1; ++f)
        for (int b = 0; b < 3; ++b) {
            const int joint = leftFingerJoint(Finger(f), b);
            add(uint8_t(joint), curl * -0.45, 6.8, 0.7, 0.3, 0.7);
            add(uint8_t(joint + kRightIndex1 - kLeftIndex1), curlRight * -0.55, 10.3, 0.6, 0.2, 0.6);
        }
    for (int j = 0; j < kBuiltinJointCount; ++j)
        motion.swayPhase_.push_back({random.uniform(0, 6.28), random.uniform(0, 6.28), random.uniform(0, 6.28)});
    if (fingers) motion.hands_.emplace(seed, durationS);
    if (headShake) motion.shake_.emplace(seed, durationS);
    return motion;
}

TruthPose SampleMotion::pose(double timeS) const {
    TruthPose pose{std::vector<Vec3d>(kBuiltinJointCount, Vec3d(0)), Vec3d(0)};
    for (const Action& a : actions_) {
        const double t = timeS - a.startS;
        const double level = ease(t / a.riseS) - ease((t - a.riseS - a.holdS) / a.fallS);
        pose.rotations[a.joint] += level * a.axisAngle;
    }
    // Breathing and balance, faded in because the motion starts at rest.
    const double in = ease(timeS / 0.8);
    for (uint8_t joint : {kSpine1, kSpine2, kSpine3, kNeck, kHead, kLeftShoulder, kRightShoulder})
        for (int c = 0; c < 3; ++c) pose.rotations[joint][c] += in * 0.012 * std::sin((1.1 + 0.35 * c) * timeS + swayPhase_[joint][c]);
    for (int c = 0; c < 3; c += 2) pose.translation[c] = in * 0.004 * std::sin((0.9 + 0.2 * c) * timeS + swayPhase_[0][c]);
    // Lifting a leg shifts the hips over the other foot.
    const double left = std::max(0.0, -pose.rotations[kLeftHip].x), right = std::max(0.0, -pose.rotations[kRightHip].x);
    pose.translation.x += 0.045 * (right - left) / 1.2;
    for (const bool side : {true, false})
        if (hands_) setHand(side, hands_->at(side, timeS), pose);
    if (shake_) shake_->turn(timeS, pose);
    return pose;
}

TruthPose staticPose(uint64_t seed, uint32_t index, bool fingers) {
    Random random(seed, 7000 + index);
    TruthPose pose{std::vector<Vec3d>(kBuiltinJointCount, Vec3d(0)), Vec3d(0)};
    auto sway = [&](uint8_t joint, double sigmaRad) {
        for (int c = 0; c < 3; ++c) pose.rotations[joint][c] = sigmaRad * std::clamp(random.normal(), -2.5, 2.5);
    };
    sway(kPelvis, 0.005);
    for (uint8_t joint : {kSpine1, kSpine2, kSpine3}) sway(joint, 0.004);
    for (uint8_t joint : {kNeck, kHead}) sway(joint, 0.007);
    for (uint8_t joint : {kLeftShoulder, kRightShoulder}) sway(joint, 0.013);
    for (uint8_t joint : {kLeftElbow, kRightElbow, kLeftWrist, kRightWrist}) sway(joint, 0.015);
    for (int c = 0; c < 3; ++c) pose.translation[c] = (c == 1 ? 0.0008 : 0.0035) * std::clamp(random.normal(), -2.5, 2.5);
    for (const bool side : {true, false})
        if (fingers) setHand(side, stillHand(seed, side, index), pose);
    return pose;
}

}  // namespace dpl
