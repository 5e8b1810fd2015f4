// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/observe/hand_crop.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

// MediaPipe's hand graphs: the crop of tracked hands is the box of wrist, thumb, knuckles and middle joints, doubled and moved a tenth of
// its side towards the fingers.
constexpr double kHandBoxRoom = 2.0, kTowardsFingers = 0.1;
constexpr std::array<size_t, 12> kPalm = {0, 1, 2, 3, 5, 6, 9, 10, 13, 14, 17, 18};
constexpr size_t kIndexBase = 5, kMiddleBase = 9, kRingBase = 13, kMiddleTip = 12;
constexpr double kPalmOfForearm = 0.3;  // distance from the wrist to the knuckles / length of the forearm
constexpr double kAheadOfWrist = 0.3;   // of the middle of a crop from the wrist, of its side
constexpr double kSamePlace = 0.25;     // of the hand's length

double angleOf(const Vec2d& up) {
    return std::atan2(up.x, -up.y);
}

}  // namespace

PersonCrop cropOfArm(const ArmMarks& arm, double room) {
    const Vec2d knuckles = (2.0 * arm.index + arm.pinky) / 3.0, palm = knuckles - arm.wrist, forearm = arm.wrist - arm.elbow;
    const double palmPx = glm::length(palm), least = kPalmOfForearm * glm::length(forearm);
    const Vec2d up = palmPx > 0.5 * least ? palm : forearm;  // knuckles in front of the wrist tell no direction
    const double side = std::max(1.0, room * std::max(palmPx, least)), length = glm::length(up);
    const Vec2d centre = arm.wrist + (length > 0 ? (kAheadOfWrist * side / length) * up : Vec2d(0));
    return {centre, side, angleOf(up)};
}

std::optional<PersonCrop> cropOfHand(const HandMarks& marks) {
    const Vec2d knuckles = 0.5 * (0.5 * (marks[kIndexBase] + marks[kRingBase]) + marks[kMiddleBase]), up = knuckles - marks[0];
    const double angle = angleOf(up), c = std::cos(angle), s = std::sin(angle);
    Vec2d low(1e30), high(-1e30);
    for (const size_t k : kPalm) {
        const Vec2d turned(c * marks[k].x + s * marks[k].y, -s * marks[k].x + c * marks[k].y);
        low = glm::min(low, turned), high = glm::max(high, turned);
    }
    const double side = kHandBoxRoom * std::max(high.x - low.x, high.y - low.y);
    if (!(side > 1) || !std::isfinite(side)) return std::nullopt;
    const Vec2d middle = 0.5 * (low + high) - Vec2d(0, 0.5 * kTowardsFingers * side);
    return PersonCrop{{c * middle.x - s * middle.y, s * middle.x + c * middle.y}, side, angle};
}

double lengthPx(const HandMarks& marks) {
    double sum = glm::length(marks[kMiddleBase] - marks[0]);
    for (size_t k = kMiddleBase; k < kMiddleTip; ++k) sum += glm::length(marks[k + 1] - marks[k]);
    return sum;
}

bool isSameHand(const HandMarks& a, const HandMarks& b) {
    double sum = 0;
    for (size_t k = 0; k < kHandMarks; ++k) sum += glm::length(a[k] - b[k]);
    return sum < kSamePlace * double(kHandMarks) * std::max(lengthPx(a), lengthPx(b));
}

std::optional<size_t> armOfHand(const Vec2d& handWrist, const Vec2d& leftWrist, const Vec2d& rightWrist) {
    const double left = glm::length(handWrist - leftWrist), right = glm::length(handWrist - rightWrist);
    if (2 * left < right) return 0;
    if (2 * right < left) return 1;
    return std::nullopt;
}

}  // namespace dpl
