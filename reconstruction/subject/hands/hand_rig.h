// SPDX-License-Identifier: Apache-2.0
// A hand as hinges. Each finger has four: its base bends and turns sideways, its middle and last joint bend. A turn of 0 is the body's rest
// pose.
#pragma once

#include <array>
#include <optional>

#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/subject/body/hand_points.h"
#include "sdk/avatar/rig.h"

namespace dpl {

constexpr size_t kFingerTurns = 4, kHandTurns = kHandFingers * kFingerTurns;
enum FingerTurn : uint8_t { kBaseBend, kBaseSide, kMiddleBend, kEndBend };

/** Turns of one hand's hinges, radians: kFingerTurns of each finger, thumb first. Positive bends curl; a positive side turn moves a finger
 *  towards the thumb, and the thumb out of the palm's plane. */
using HandTurns = std::array<double, kHandTurns>;

struct FingerRig {
    FingerJoints joints{};
    std::array<Vec3d, kFingerPoints> places{};  // three joints and the tip; metres from the wrist, rest frame
    std::array<Vec3d, 3> bendAxes{};            // unit, rest frame
    Vec3d sideAxis{0};
};

struct HandRig {
    uint32_t wrist = 0;
    double lengthM = 0;  // from the wrist to the middle finger's tip at rest
    std::array<FingerRig, kHandFingers> fingers;
    HandTurns low{}, high{};  // limits; low ≤ 0 ≤ high
};

/** The hand of a body in its shape, or nothing where it lacks the wrist, one of the 15 joints or a fingertip. The side of the palm follows
 *  from the places of wrist, index and pinky, so fingers may be straight at rest. */
std::optional<HandRig> handRig(const BodyModel& shaped, bool left);

/** `v` turned about the unit axis `a`. */
template <class T>
std::array<T, 3> turned(const std::array<T, 3>& v, const Vec3d& a, const T& angleRad) {
    using std::cos, std::sin;
    const T c = cos(angleRad), s = sin(angleRad), along = (1.0 - c) * (a.x * v[0] + a.y * v[1] + a.z * v[2]);
    return {c * v[0] + s * (a.y * v[2] - a.z * v[1]) + along * a.x, c * v[1] + s * (a.z * v[0] - a.x * v[2]) + along * a.y,
            c * v[2] + s * (a.x * v[1] - a.y * v[0]) + along * a.z};
}

/** The points of a finger in the rest frame of the wrist, metres from it. `turns`: kFingerTurns values. */
template <class T>
std::array<std::array<T, 3>, kFingerPoints> fingerPoints(const FingerRig& finger, const T* turns) {
    const auto lifted = [](const Vec3d& v) { return std::array<T, 3>{T(v.x), T(v.y), T(v.z)}; };
    std::array<std::array<T, 3>, kFingerPoints> points;
    points[0] = lifted(finger.places[0]);
    for (size_t bone = 0; bone < 3; ++bone) {
        std::array<T, 3> v = lifted(finger.places[bone + 1] - finger.places[bone]);
        if (bone >= 2) v = turned(v, finger.bendAxes[2], turns[kEndBend]);
        if (bone >= 1) v = turned(v, finger.bendAxes[1], turns[kMiddleBend]);
        v = turned(turned(v, finger.bendAxes[0], turns[kBaseBend]), finger.sideAxis, turns[kBaseSide]);
        for (size_t c = 0; c < 3; ++c) points[bone + 1][c] = points[bone][c] + v[c];
    }
    return points;
}

/** Sets the rotations of the hand's 15 joints. */
void setFingers(const HandRig& hand, const HandTurns& turns, Pose& pose);

}  // namespace dpl
