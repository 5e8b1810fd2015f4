// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/hand_motion.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/sample/ease.h"
#include "reconstruction/subject/sample/random.h"

namespace dpl {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr uint64_t kHandStream = 8100, kStillHandStream = 8200, kGestureStream = 8300;
constexpr std::array<double, kFingerCount> kFan = {0.5, 0.12, -0.5, -0.22, 0};  // share of the spread from index to pinky

HandPose degrees(HandPose hand) {
    for (auto& finger : hand)
        for (double& turn : finger) turn *= kDegree;
    return hand;
}

HandPose fanned(HandPose hand, double spreadRad) {
    for (int f = 0; f < kThumb; ++f) hand[f][kSpread] = kFan[f] * spreadRad;
    return hand;
}

HandPose mixed(const HandPose& a, const HandPose& b, double share) {
    HandPose out{};
    for (int f = 0; f < kFingerCount; ++f)
        for (int t = 0; t < kHandTurnCount; ++t) out[f][t] = (1 - share) * a[f][t] + share * b[f][t];
    return out;
}

/** Fist, point, spread, pinch: index, middle, pinky, ring, thumb. */
std::array<HandPose, 4> gestures() {
    constexpr std::array<double, kHandTurnCount> kClosed = {70, 0, 88, 50}, kThumbOver = {24, 20, 30, 40};
    return {degrees({kClosed, kClosed, kClosed, kClosed, kThumbOver}), degrees({{{0, 0, 0, 0}, kClosed, kClosed, kClosed, kThumbOver}}),
            fanned(degrees({{{-6, 0, -3, -2}, {-6, 0, -3, -2}, {-4, 0, -3, -2}, {-6, 0, -3, -2}, {-12, 8, -4, -6}}}), 20 * kDegree),
            degrees({{{42, 0, 45, 25}, {30, 0, 30, 15}, {18, 0, 20, 10}, {24, 0, 24, 12}, {16, 26, 18, 22}}})};
}

Vec3d axisAngleOf(const Quatd& turn) {
    const Quatd q = turn.w < 0 ? -turn : turn;
    const Vec3d v(q.x, q.y, q.z);
    const double s = glm::length(v);
    return s < 1e-12 ? 2.0 * v : (2 * std::atan2(s, q.w) / s) * v;
}

}  // namespace

HandPose seededHand(uint64_t seed, bool left) {
    Random random(seed, kHandStream + (left ? 0 : 1));
    HandPose hand{};
    const double curl = random.uniform(0, 60) * kDegree;
    for (int f = 0; f < kThumb; ++f) {
        const auto joint = [&](double share) { return std::clamp(share * curl + random.uniform(-6, 6) * kDegree, 0.0, 60 * kDegree); };
        hand[f] = {joint(0.7), 0, joint(1.0), joint(0.6)};
    }
    hand = fanned(hand, random.uniform(0, 20) * kDegree);
    hand[kThumb] = {random.uniform(-10, 28) * kDegree, random.uniform(0, 22) * kDegree, random.uniform(0, 25) * kDegree,
                    random.uniform(-5, 35) * kDegree};
    return hand;
}

HandPose stillHand(uint64_t seed, bool left, uint32_t index) {
    Random random(seed, kStillHandStream + 2 * uint64_t(index) + (left ? 0 : 1));
    HandPose hand = seededHand(seed, left);
    for (auto& finger : hand)
        for (double& turn : finger) turn += kDegree * std::clamp(random.normal(), -2.5, 2.5);
    return hand;
}

HandMotion::HandMotion(uint64_t seed, double durationS) : slotS_(durationS / 4.4) {
    for (int side = 0; side < 2; ++side) {
        Random random(seed, kGestureStream + uint64_t(side));
        Hand& hand = hands_[size_t(side)];
        hand.relaxed = seededHand(seed, side == 0);
        hand.gestures = gestures();
        for (uint32_t i = 3; i > 0; --i) std::swap(hand.gestures[i], hand.gestures[random.below(i + 1)]);
        hand.startS = slotS_ * random.uniform(0.05, 0.35);
    }
}

HandPose HandMotion::at(bool left, double timeS) const {
    const Hand& hand = hands_[left ? 0 : 1];
    HandPose pose = hand.relaxed;
    for (size_t i = 0; i < hand.gestures.size(); ++i) {
        const double t = (timeS - hand.startS) / slotS_ - double(i);  // in slots
        pose = mixed(pose, hand.gestures[i], ease(t / 0.25) - ease((t - 0.6) / 0.25));
    }
    return pose;
}

void setHand(bool left, const HandPose& hand, TruthPose& pose) {
    const HandFrame frame = leftHandFrame();
    const Vec3d along(frame.along), thumbward(frame.thumbward), palm(-frame.dorsal);
    const Vec3d sideways = glm::normalize(glm::cross(along, thumbward));
    for (int f = 0; f < kFingerCount; ++f) {
        const auto chain = leftFingerChain(Finger(f));
        const bool thumb = f == kThumb;
        // A thumb's nail faces away from the palm's middle, so it bends across the palm.
        const Vec3d inwards = thumb ? glm::normalize(0.57 * palm - 0.82 * thumbward) : palm;
        for (int b = 0; b < 3; ++b) {
            const Vec3d bone = glm::normalize(Vec3d(chain[size_t(b) + 1] - chain[size_t(b)]));
            const Vec3d bend = glm::normalize(glm::cross(bone, inwards));
            const Vec3d second = thumb ? glm::normalize(glm::cross(bone, palm)) : sideways;
            const double angle = hand[f][b == 0 ? kBase : b == 1 ? kMiddleJoint : kEndJoint];
            const Quatd turn = glm::angleAxis(b == 0 ? hand[f][kSpread] : 0.0, second) * glm::angleAxis(angle, bend);
            const Vec3d axisAngle = axisAngleOf(turn);
            const int joint = leftFingerJoint(Finger(f), b);
            if (left)
                pose.rotations[size_t(joint)] = axisAngle;
            else  // the mirror image
                pose.rotations[size_t(joint + kRightIndex1 - kLeftIndex1)] = {axisAngle.x, -axisAngle.y, -axisAngle.z};
        }
    }
}

}  // namespace dpl
