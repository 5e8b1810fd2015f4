// SPDX-License-Identifier: Apache-2.0
// Where the network of hands looks, and whose the hand is that it finds.
#include "reconstruction/input/observe/hand_crop.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstruction/input/observe/hand_finder.h"
#include "reconstruction/input/observe/pose_crop.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_capture/scan_builder.h"

namespace dpl {
namespace {

constexpr double kTurn = 1.5707963267948966;

/** A flat hand of 100 px whose fingers point up, turned clockwise by `angleRad` about its wrist at `wrist`. */
HandMarks flatHand(const Vec2d& wrist, double angleRad = 0) {
    HandMarks marks{};
    for (size_t f = 0; f < kHandFingers; ++f)
        for (size_t k = 0; k < kFingerPoints; ++k)
            marks[1 + f * kFingerPoints + k] = Vec2d(12.0 * (double(f) - 2), f == 0 ? -10 - 15.0 * double(k) : -45 - 18.0 * double(k));
    const double c = std::cos(angleRad), s = std::sin(angleRad);
    for (Vec2d& p : marks) p = wrist + Vec2d(c * p.x - s * p.y, s * p.x + c * p.y);
    return marks;
}

TEST(HandCrop, ofAnArmTurnsItsKnucklesUp) {
    const ArmMarks right{{0, 100}, {100, 100}, {140, 95}, {140, 110}};  // the forearm points to the picture's right
    const PersonCrop crop = cropOfArm(right, 2.5);
    EXPECT_NEAR(crop.angleRad, kTurn, 1e-9);
    EXPECT_NEAR(crop.sidePx, 100, 1e-9);
    EXPECT_GT(crop.centrePx.x, 100);
    EXPECT_NEAR(crop.centrePx.y, 100, 1e-9);
    EXPECT_GT(cropOfArm(right, 5).sidePx, 1.9 * crop.sidePx);
}

TEST(HandCrop, ofAHandThatPointsAtTheCameraHasTheSizeAndTurnOfTheForearm) {
    const ArmMarks towards{{100, 0}, {100, 100}, {101, 99}, {100, 99}};  // the forearm points down
    const PersonCrop crop = cropOfArm(towards, 2);
    EXPECT_NEAR(std::abs(crop.angleRad), 2 * kTurn, 1e-9);
    EXPECT_NEAR(crop.sidePx, 60, 1e-9);
    const PersonCrop nowhere = cropOfArm({{5, 5}, {5, 5}, {5, 5}, {5, 5}}, 2);
    EXPECT_TRUE(std::isfinite(nowhere.centrePx.x + nowhere.angleRad));
    EXPECT_GE(nowhere.sidePx, 1);
}

TEST(HandCrop, ofAHandHoldsAllOfItAndTurnsWithIt) {
    const PersonCrop upright = *cropOfHand(flatHand({200, 300}));
    for (const double angle : {0.0, 0.7, 2.5, -2.0}) {
        const HandMarks marks = flatHand({200, 300}, angle);
        const PersonCrop crop = *cropOfHand(marks);
        EXPECT_NEAR(std::remainder(crop.angleRad - upright.angleRad - angle, 4 * kTurn), 0, 1e-9);
        EXPECT_NEAR(crop.sidePx, upright.sidePx, 1e-9);
        for (const Vec2d& p : marks) {
            const Vec2d across = cropToPicture(crop, {1, 0}, 1) - cropToPicture(crop, {0, 0}, 1), from = p - crop.centrePx;
            EXPECT_LT(std::abs(glm::dot(from, glm::normalize(across))), 0.5 * crop.sidePx);
            EXPECT_LT(std::abs(glm::dot(from, Vec2d(-across.y, across.x) / glm::length(across))), 0.5 * crop.sidePx);
        }
    }
    HandMarks point;
    point.fill({7, 7});
    EXPECT_FALSE(cropOfHand(point));
    point[5].x = NAN;
    EXPECT_FALSE(cropOfHand(point));
}

TEST(HandCrop, oneHandAtTwoWristsIsThatOfTheNearerOne) {
    const HandMarks hand = flatHand({100, 100}), besides = flatHand({160, 100});
    EXPECT_TRUE(isSameHand(hand, flatHand({104, 97}, 0.05)));
    EXPECT_FALSE(isSameHand(hand, besides));
    EXPECT_EQ(armOfHand({100, 100}, {103, 100}, {140, 100}), 0u);
    EXPECT_EQ(armOfHand({100, 100}, {60, 100}, {103, 100}), 1u);
    EXPECT_FALSE(armOfHand({100, 100}, {90, 100}, {112, 100})) << "crossed wrists: it may be of either arm";
}

TEST(HandFinder, aFolderWithoutItsNetworksFindsNoHands) {
    TemporaryFolder folder;
    EXPECT_FALSE(must(HandFinder::loadIfThere(folder.path)));
    writeText(folder.path / "hand_landmarks.onnx", "not a network");
    const auto damaged = HandFinder::loadIfThere(folder.path);
    ASSERT_FALSE(damaged);
    EXPECT_TRUE(mentions(damaged.error().message, {"hand_landmarks.onnx", "download"}));
}

}  // namespace
}  // namespace dpl
