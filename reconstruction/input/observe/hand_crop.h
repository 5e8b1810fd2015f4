// SPDX-License-Identifier: Apache-2.0
// Squares of a picture in which the network of hands gets a hand, its fingers pointing up. Private to reconstruction/input/observe and its
// tests.
#pragma once

#include <array>
#include <optional>

#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/input/observe/observations.h"

namespace dpl {

constexpr size_t kHandMarks = 1 + kHandPoints;

/** The wrist of a hand, then its points in the order of handKeypointNames(), pixels of the picture. */
using HandMarks = std::array<Vec2d, kHandMarks>;

/** What the pose network marks of an arm, pixels. */
struct ArmMarks {
    Vec2d elbow{0}, wrist{0}, index{0}, pinky{0};
};

/** The square in which an arm's hand should be, `room` times as large as the palm is long. That comes from wrist and knuckles, and from the
 *  forearm where the hand points at the camera. */
PersonCrop cropOfArm(const ArmMarks& arm, double room);

/** The square that a hand's own marks ask for. Nothing when they lie in one place. */
std::optional<PersonCrop> cropOfHand(const HandMarks& marks);

/** From the wrist to the tip of the middle finger along its joints, pixels. */
double lengthPx(const HandMarks& marks);

/** Whether two found hands are one and the same of the picture: their marks lie less than a quarter of its length apart. */
bool isSameHand(const HandMarks& a, const HandMarks& b);

/** Whose the one hand is that was found at both wrists, because arms cross or one hides a hand: 0 the left arm's, 1 the right one's.
 * Nothing where neither wrist is twice as near as the other. */
std::optional<size_t> armOfHand(const Vec2d& handWrist, const Vec2d& leftWrist, const Vec2d& rightWrist);

}  // namespace dpl
