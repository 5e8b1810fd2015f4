// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/hands/hand_rig.h"

#include <gtest/gtest.h>

#include "reconstruction/subject/body/body_truth.h"
#include "tests/unit/recon_hands/known_body.h"

namespace dpl {
namespace {

TEST(HandRig, turnsPointsAsThePosedBodyDoes) {
    for (const bool left : {true, false}) {
        const auto hand = handRig(knownBody(), left);
        ASSERT_TRUE(hand);
        HandTurns turns{};
        for (size_t t = 0; t < turns.size(); ++t) turns[t] = (t % 3 == 0 ? 0.6 : 0.3) * (t % 2 ? hand->high[t] : hand->low[t]);
        const size_t first = left ? 0 : kHandPoints;
        Pose pose = Pose::rest(knownBody().joints.size());
        setFingers(*hand, turns, pose);
        const auto posed = posedKeypoints(knownBody(), pose, handNames());
        const Vec3d wrist(knownBody().joints[hand->wrist].restPosition);
        for (size_t f = 0; f < kHandFingers; ++f) {
            const auto points = fingerPoints(hand->fingers[f], &turns[f * kFingerTurns]);
            for (size_t i = 0; i < kFingerPoints; ++i) {
                const Vec3d is = wrist + Vec3d(points[i][0], points[i][1], points[i][2]);
                // Skin at a tip belongs to the last joint by 98 % or more, so it lags behind the hinge by a little.
                EXPECT_LT(glm::length(is - posed[first + f * kFingerPoints + i].place), i == 3 ? 1.5e-3 : 1e-5)
                    << handNames()[first + f * kFingerPoints + i];
            }
        }
    }
}

TEST(HandRig, curlsIntoThePalmAndOpposesTheThumbOnBothSides) {
    for (const bool left : {true, false}) {
        const auto hand = handRig(knownBody(), left);
        ASSERT_TRUE(hand);
        EXPECT_NEAR(hand->lengthM, 0.19, 0.02);
        HandTurns fist{};
        for (size_t f = 1; f < kHandFingers; ++f)
            for (const FingerTurn t : {kBaseBend, kMiddleBend, kEndBend}) fist[f * kFingerTurns + t] = 1.2;
        const auto tipOf = [&](size_t f, const HandTurns& turns) {
            const auto p = fingerPoints(hand->fingers[f], &turns[f * kFingerTurns])[3];
            return Vec3d(p[0], p[1], p[2]);
        };
        for (size_t f = 1; f < kHandFingers; ++f) {
            EXPECT_LT(glm::length(tipOf(f, fist)), 0.75 * glm::length(tipOf(f, {}))) << "a curled fingertip comes nearer to the wrist";
            EXPECT_LT(tipOf(f, fist).y, hand->fingers[f].places[0].y) << "palms look down at rest";
        }
        HandTurns in{}, spread{};
        in[kBaseBend] = 0.5, spread[kFingerTurns + kBaseSide] = 0.3;
        EXPECT_LT(glm::length(tipOf(0, in) - tipOf(4, {})), glm::length(tipOf(0, {}) - tipOf(4, {}))) << "the thumb comes to the pinky";
        EXPECT_LT(glm::length(tipOf(0, {}) - tipOf(1, spread)), glm::length(tipOf(0, {}) - tipOf(1, {}))) << "the index comes to the thumb";
    }
}

TEST(HandRig, aBodyWithoutFingersHasNone) {
    BodyModel mitten = knownBody();
    std::erase_if(mitten.keypoints, [](const BodyKeypoint& k) { return k.name == "ring4_l"; });
    EXPECT_FALSE(handRig(mitten, true));
    EXPECT_TRUE(handRig(mitten, false));
    for (JointData& joint : mitten.joints)
        if (joint.humanoidBone == "rightLittleDistal") joint.humanoidBone.clear();
    EXPECT_FALSE(handRig(mitten, false));
}

}  // namespace
}  // namespace dpl
