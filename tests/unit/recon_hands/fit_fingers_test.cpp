// SPDX-License-Identifier: Apache-2.0
// The finger fit on the built-in body with known poses: what is found, and what must stay as it is.
#include "reconstruction/subject/hands/fit_fingers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reconstruction/subject/body/body_truth.h"
#include "reconstruction/subject/body/swapped_sides.h"
#include "reconstruction/subject/hands/hand_rig.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_hands/known_body.h"

namespace dpl {
namespace {

/** A scan of the built-in body at rest, whose hands alone move; `fit` is exact but for the fingers. */
struct Made {
    Scan scan;
    std::vector<std::vector<Keypoint>> hands;
    std::vector<Pose> truth;
    BodyFit fit;
};

HandTurns bent(const HandRig& hand, double bend, double side) {
    HandTurns turns{};
    for (size_t f = 0; f < kHandFingers; ++f) {
        double* t = &turns[f * kFingerTurns];
        t[kBaseBend] = bend * (f == 0 ? 0.4 : 0.8), t[kMiddleBend] = bend, t[kEndBend] = 0.66 * bend;
        t[kBaseSide] = f == 0 ? side : side * (2.2 - double(f)) / 2;
    }
    for (size_t t = 0; t < turns.size(); ++t) turns[t] = std::clamp(turns[t], hand.low[t], hand.high[t]);
    return turns;
}

/** `still`: bend of the fingers of still frames; moving ones go from there to `most` and back. */
Made make(double still, double most, double noisePx = 1, int movingFrames = 12) {
    Made m;
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    m.scan.keypointNames = {"nose"};
    const auto add = [&](FrameKind kind, Split split, double timeS, double azimuth, double distanceM, double bend) {
        ScanFrame frame;
        frame.name = formatText("f{}", m.scan.frames.size()), frame.kind = kind, frame.split = split, frame.timeS = timeS;
        Camerad& c = frame.camera;
        c.widthPx = 378, c.heightPx = 504, c.fx = c.fy = 380, c.cx = 189, c.cy = 252;
        const Vec3d eye(distanceM * std::sin(azimuth), 1.2, distanceM * std::cos(azimuth)), target(0, 0.95, 0);
        const Vec3d z = glm::normalize(target - eye), x = glm::normalize(glm::cross(Vec3d(0, -1, 0), z)), y = glm::cross(z, x);
        c.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
        c.viewFromWorldTranslation = -(c.viewFromWorldRotation * eye);
        Pose pose = Pose::rest(knownBody().joints.size());
        m.fit.poses.push_back(pose);
        for (const bool left : {true, false}) {
            const auto hand = handRig(knownBody(), left);
            setFingers(*hand, bent(*hand, bend, 0.1), pose);
        }
        std::vector<Keypoint> points;
        for (const PosedKeypoint& p : posedKeypoints(knownBody(), pose, handNames()))
            points.push_back({c.pixelOf(c.toView(p.place)) + noisePx * Vec2d(normal(random), normal(random)), 0.9});
        m.scan.frames.push_back(frame), m.hands.push_back(points), m.truth.push_back(pose);
    };
    for (int i = 0; i < 12; ++i) add(FrameKind::StaticFull, i == 5 ? Split::Test : Split::Train, 0, 0.52 * i, 2.0, still);
    for (int i = 0; i < movingFrames; ++i)
        add(FrameKind::Dynamic, i % 6 == 3 ? Split::Test : Split::Train, 0.2 * i, 0.2 * i, 2.2,
            still + 0.5 * (most - still) * (1 - std::cos(0.5 * i)));
    m.fit.shape.assign(knownBody().morphs.size(), 0.0);
    m.fit.staticPose = m.fit.poses[0];
    m.fit.fitted.assign(m.scan.frames.size(), true);
    return m;
}

/** The largest and the mean distance of fingertips between two poses of the same frames, mm. */
std::pair<double, double> tipsMm(const std::vector<Pose>& a, const std::vector<Pose>& b) {
    double most = 0, sum = 0;
    size_t count = 0;
    for (size_t f = 0; f < a.size(); ++f) {
        const auto p = posedKeypoints(knownBody(), a[f], handNames()), q = posedKeypoints(knownBody(), b[f], handNames());
        for (size_t k = kFingerPoints - 1; k < p.size(); k += kFingerPoints) {
            const double mm = 1000 * glm::length(p[k].place - q[k].place);
            most = std::max(most, mm), sum += mm, ++count;
        }
    }
    return {most, sum / double(count)};
}

/** The turns of a finger's four hinges in a pose; the reverse of setFingers(). */
std::array<double, kFingerTurns> turnsIn(const Pose& pose, const FingerRig& finger) {
    const auto about = [](const Quatd& q, const Vec3d& axis) { return 2 * std::atan2(glm::dot(Vec3d(q.x, q.y, q.z), axis), q.w); };
    const Quatd base(pose.localRotations[finger.joints[0]]);
    const auto across = [&](const Vec3d& v) { return v - glm::dot(v, finger.sideAxis) * finger.sideAxis; };
    const Vec3d from = across(finger.bendAxes[0]), to = across(base * finger.bendAxes[0]);  // which the bend itself leaves in place
    const double side = std::atan2(glm::dot(finger.sideAxis, glm::cross(from, to)), glm::dot(from, to));
    const Quatd bend = glm::angleAxis(-side, finger.sideAxis) * base;
    return {about(bend, finger.bendAxes[0]), side, about(Quatd(pose.localRotations[finger.joints[1]]), finger.bendAxes[1]),
            about(Quatd(pose.localRotations[finger.joints[2]]), finger.bendAxes[2])};
}

void expectLimits(const std::vector<Pose>& poses) {
    for (const Pose& pose : poses)
        for (const bool left : {true, false}) {
            const auto hand = handRig(knownBody(), left);
            for (size_t f = 0; f < kHandFingers; ++f) {
                const auto turns = turnsIn(pose, hand->fingers[f]);
                for (size_t t = 0; t < kFingerTurns; ++t) {
                    ASSERT_GT(turns[t], hand->low[f * kFingerTurns + t] - 1e-4) << "finger " << f << " turn " << t;
                    ASSERT_LT(turns[t], hand->high[f * kFingerTurns + t] + 1e-4) << "finger " << f << " turn " << t;
                }
            }
        }
}

bool hasStillFingers(const Made& m, size_t f, bool left) {
    const auto hand = *handRig(knownBody(), left);
    for (const FingerRig& finger : hand.fingers)
        for (const uint32_t joint : finger.joints)
            if (m.fit.poses[f].localRotations[joint] != m.fit.staticPose.localRotations[joint]) return false;
    return true;
}

TEST(FitFingers, findsTheStillHandAndItsMotion) {
    Made m = make(0.5, 1.3);
    const auto before = m.fit.poses;
    const std::vector<HandFit> hands = must(fitFingers(knownBody(), m.scan, m.hands, m.fit));
    const auto [most, mean] = tipsMm(m.fit.poses, m.truth);
    const auto [mostBefore, meanBefore] = tipsMm(before, m.truth);
    std::printf("fingertips %.1f mm from the truth, at most %.1f; at rest %.1f and %.1f\n", mean, most, meanBefore, mostBefore);
    EXPECT_LT(mean, 8);  // moving hands are 33 px long in one view, and 1 px is 6 mm; 6.8 measured
    EXPECT_GT(meanBefore, 30);
    ASSERT_EQ(hands.size(), 2u);
    for (const HandFit& hand : hands) {
        EXPECT_TRUE(hand.turned);
        EXPECT_EQ(hand.stillFrames, 12u);
        EXPECT_GE(hand.posedFrames, 8u);       // at the ends of the motion the still pose is as good
        EXPECT_NEAR(hand.medianPx, 1.2, 0.4);  // the median of a Rayleigh distribution
        ASSERT_EQ(hand.precisions.size(), m.scan.frames.size());
        size_t known = 0;
        for (const auto& precision : hand.precisions) {
            known += precision.has_value();
            if (precision) EXPECT_EQ(precision->joints.size(), 1 + 3 * kHandFingers);
        }
        EXPECT_GE(known, 20u);
    }
    expectLimits(m.fit.poses);
}

TEST(FitFingers, fingersAtRestStayThere) {
    Made m = make(0, 0);
    const auto before = m.fit.poses;
    // Hands exactly at rest: the noise alone must not turn them.
    const BodyModel& b = knownBody();
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (size_t f = 0; f < m.hands.size(); ++f) {
        const auto rest = posedKeypoints(b, before[f], handNames());
        const Camerad& c = m.scan.frames[f].camera;
        for (size_t k = 0; k < rest.size(); ++k)
            m.hands[f][k].px = c.pixelOf(c.toView(rest[k].place)) + 1.5 * Vec2d(normal(random), normal(random));
    }
    ASSERT_TRUE(fitFingers(b, m.scan, m.hands, m.fit));
    EXPECT_LE(tipsMm(before, m.fit.poses).first, 3);
}

TEST(FitFingers, aScanWithoutHandsKeepsItsBytes) {
    Made m = make(0.5, 1);
    const BodyFit before = m.fit;
    for (auto& points : m.hands) points.clear();
    EXPECT_TRUE(must(fitFingers(knownBody(), m.scan, m.hands, m.fit)).empty());
    for (size_t f = 0; f < before.poses.size(); ++f) EXPECT_EQ(before.poses[f].localRotations, m.fit.poses[f].localRotations);
    EXPECT_EQ(before.staticPose.localRotations, m.fit.staticPose.localRotations);
}

TEST(FitFingers, heldOutFramesReachNoTrainingFrame) {
    Made a = make(0.5, 1.3), b = make(0.5, 1.3);
    for (size_t f = 0; f < b.hands.size(); ++f)
        if (b.scan.frames[f].split == Split::Test)
            for (Keypoint& k : b.hands[f]) k.px.x += 5 * std::sin(double(k.px.y));
    ASSERT_TRUE(fitFingers(knownBody(), a.scan, a.hands, a.fit));
    ASSERT_TRUE(fitFingers(knownBody(), b.scan, b.hands, b.fit));
    bool testDiffers = false;
    for (size_t f = 0; f < a.fit.poses.size(); ++f) {
        const bool same = a.fit.poses[f].localRotations == b.fit.poses[f].localRotations;
        if (a.scan.frames[f].split == Split::Test)
            testDiffers |= !same;
        else
            EXPECT_TRUE(same) << f;
    }
    EXPECT_TRUE(testDiffers);  // proves that the points were read
}

TEST(FitFingers, strangeHandsLeaveTheFingersAlone) {
    // Points of nobody's hand; a hand half a metre beside the wrist; hands too small; hands that the detector hardly believes in.
    for (int kind = 0; kind < 4; ++kind) {
        Made m = make(0.6, 1.2);
        const auto before = m.fit.poses;
        std::mt19937 random(11);
        std::uniform_real_distribution<double> anywhere(-40, 40);
        for (size_t f = 0; f < m.hands.size(); ++f)
            for (Keypoint& k : m.hands[f]) {
                if (kind == 0) k.px += Vec2d(anywhere(random), anywhere(random));
                if (kind == 1) k.px.x += 90;
                if (kind == 3) k.confidence = 0.2;
            }
        if (kind == 2)
            for (ScanFrame& frame : m.scan.frames) frame.camera = frame.camera.scaled(0.4);
        const std::vector<HandFit> hands = must(fitFingers(knownBody(), m.scan, m.hands, m.fit));
        EXPECT_EQ(tipsMm(before, m.fit.poses).first, 0) << "kind " << kind;
        for (const HandFit& hand : hands)
            for (const auto& precision : hand.precisions) EXPECT_FALSE(precision) << "kind " << kind;
        expectLimits(m.fit.poses);
    }
}

TEST(FitFingers, aHiddenHandKeepsTheStillPose) {
    Made m = make(0.5, 1.3);
    for (size_t f = 0; f < m.hands.size(); ++f)
        if (m.scan.frames[f].kind == FrameKind::Dynamic)
            for (size_t k = 0; k < kHandPoints; ++k) m.hands[f][k].confidence = 0;
    const std::vector<HandFit> hands = must(fitFingers(knownBody(), m.scan, m.hands, m.fit));
    for (size_t f = 0; f < m.hands.size(); ++f) EXPECT_TRUE(hasStillFingers(m, f, /*left=*/true));
    for (size_t f = 0; f < m.hands.size(); ++f)
        if (m.scan.frames[f].kind == FrameKind::Dynamic) EXPECT_FALSE(hands[0].precisions[f]) << f;
    EXPECT_EQ(hands[0].posedFrames, 0u);
    EXPECT_GE(hands[1].posedFrames, 8u);
}

TEST(FitFingers, handsFollowTheSidesThatTheBodyFitGave) {
    Made m = make(0.5, 1.3, /*noisePx=*/1, /*movingFrames=*/0), exchanged = m;
    const size_t turned = 4;
    std::rotate(exchanged.hands[turned].begin(), exchanged.hands[turned].begin() + kHandPoints, exchanged.hands[turned].end());
    exchanged.fit.swapped.assign(m.scan.frames.size(), kNoneSwapped);
    exchanged.fit.swapped[turned] = kUpperSwapped;
    ASSERT_TRUE(fitFingers(knownBody(), m.scan, m.hands, m.fit));
    ASSERT_TRUE(fitFingers(knownBody(), exchanged.scan, exchanged.hands, exchanged.fit));
    EXPECT_EQ(m.fit.staticPose.localRotations, exchanged.fit.staticPose.localRotations);
    EXPECT_GT(tipsMm(m.fit.poses, std::vector<Pose>(m.fit.poses.size(), Pose::rest(knownBody().joints.size()))).second, 20);
}

TEST(FitFingers, aMittenBendsNoFingerBeyondItsLimits) {
    Made m = make(0.5, 1.3);
    const auto before = m.fit.poses;
    for (auto& points : m.hands)
        for (size_t k = 0; k < points.size(); ++k) {
            const size_t inHand = k % kHandPoints;  // all fingers but the thumb lie where the middle one is
            if (inHand >= kFingerPoints) points[k] = points[k - inHand + 2 * kFingerPoints + inHand % kFingerPoints];
        }
    ASSERT_TRUE(fitFingers(knownBody(), m.scan, m.hands, m.fit));
    expectLimits(m.fit.poses);
    EXPECT_LT(tipsMm(m.fit.poses, m.truth).second, tipsMm(before, m.truth).second) << "worse than fingers that were never fitted";
}

TEST(FitFingers, handsThatTheNetworkExchangesKeepTheStillPose) {
    Made m = make(0.5, 1.3);
    std::vector<size_t> crossed;
    for (size_t f = 0; f < m.hands.size(); ++f)
        if (m.scan.frames[f].kind == FrameKind::Dynamic && f % 3 == 0) crossed.push_back(f);
    for (const size_t f : crossed) std::rotate(m.hands[f].begin(), m.hands[f].begin() + kHandPoints, m.hands[f].end());
    const std::vector<HandFit> hands = must(fitFingers(knownBody(), m.scan, m.hands, m.fit));
    for (const size_t f : crossed) EXPECT_TRUE(hasStillFingers(m, f, true) && hasStillFingers(m, f, false)) << f;
    EXPECT_GE(hands[0].posedFrames, 4u);
    expectLimits(m.fit.poses);
}

TEST(FitFingers, theHandOfAnotherPersonTurnsNoFinger) {
    Made m = make(0.5, 1.3), alone = m;
    for (size_t f = 0; f < m.hands.size(); f += 4)  // a fist beside the left hand, in its place
        for (size_t k = 0; k < kHandPoints; ++k) {
            Keypoint& point = m.hands[f][k];
            point.px = m.hands[f][0].px + 0.4 * (point.px - m.hands[f][0].px) + Vec2d(70, -30);
        }
    ASSERT_TRUE(fitFingers(knownBody(), alone.scan, alone.hands, alone.fit));
    ASSERT_TRUE(fitFingers(knownBody(), m.scan, m.hands, m.fit));
    for (size_t f = 0; f < m.hands.size(); f += 4) EXPECT_TRUE(hasStillFingers(m, f, true)) << f;
    EXPECT_LT(tipsMm({m.fit.staticPose}, {alone.fit.staticPose}).first, 12)
        << "three of eleven still frames are of somebody else; 8.8 measured";
    expectLimits(m.fit.poses);
}

TEST(FitFingers, aSixthFingerLeavesTheOthersWhereTheyAre) {
    Made m = make(0.5, 1.3), five = m;
    for (size_t f = 0; f < m.hands.size(); ++f)
        for (size_t side = 0; side < 2; ++side) {  // what the network calls the pinky stands off beyond the thumb
            Keypoint* hand = &m.hands[f][side * kHandPoints];
            const Vec2d across = hand[kFingerPoints].px - hand[4 * kFingerPoints].px;  // from the pinky to the index finger
            for (size_t k = 0; k < kFingerPoints; ++k) hand[4 * kFingerPoints + k].px += 1.6 * across;
        }
    ASSERT_TRUE(fitFingers(knownBody(), five.scan, five.hands, five.fit));
    ASSERT_TRUE(fitFingers(knownBody(), m.scan, m.hands, m.fit));
    expectLimits(m.fit.poses);
    const auto names = handNames();
    for (size_t k = kFingerPoints - 1; k < 4 * kFingerPoints; k += kFingerPoints) {
        const auto tip = [&](const Made& made) { return posedKeypoints(knownBody(), made.fit.staticPose, names)[k].place; };
        EXPECT_LT(glm::length(tip(m) - tip(five)), 0.025) << names[k];  // at most 0.018 measured, of a hand of 0.18 m
    }
}

TEST(FitFingers, aHandInACloseupIsThatOfTheWristAtWhichItLies) {
    Made m = make(0.5, 1.3, /*noisePx=*/1, /*movingFrames=*/0);
    for (ScanFrame& frame : m.scan.frames) frame.kind = FrameKind::StaticCloseup;
    Made wrong = m;
    const size_t first = 4, second = 7;
    for (const size_t f : {first, second}) {  // one whose sides are exchanged; one with a single hand of the wrong name, and no body
        std::rotate(wrong.hands[f].begin(), wrong.hands[f].begin() + kHandPoints, wrong.hands[f].end());
        for (size_t k = 0; f == second && k < kHandPoints; ++k) m.hands[f][kHandPoints + k] = {}, wrong.hands[f][k] = {};
    }
    m.fit.fitted[second] = wrong.fit.fitted[second] = false;
    ASSERT_TRUE(fitFingers(knownBody(), m.scan, m.hands, m.fit));
    ASSERT_TRUE(fitFingers(knownBody(), wrong.scan, wrong.hands, wrong.fit));
    EXPECT_EQ(m.fit.staticPose.localRotations, wrong.fit.staticPose.localRotations);
    EXPECT_FALSE(hasStillFingers(Made{{}, {}, {}, {.staticPose = Pose::rest(knownBody().joints.size()), .poses = m.fit.poses}}, 0, true));
}

TEST(FitFingers, pointsOfANetworkAreAsExactAsTheHandIsLarge) {
    // Close-ups with errors of a twentieth of the hand's length: by the noise of the body's points, 1.5 px, that is no hand.
    for (const bool found : {false, true}) {
        Made m = make(0.5, 0.5, /*noisePx=*/0, /*movingFrames=*/0);
        std::mt19937 random(3);
        std::normal_distribution<double> normal;
        for (ScanFrame& frame : m.scan.frames)
            frame.camera = frame.camera.scaled(8), frame.camera.widthPx = 378, frame.camera.heightPx = 504;
        for (auto& points : m.hands)
            for (Keypoint& k : points) k.px = 8.0 * k.px + 14.0 * Vec2d(normal(random), normal(random));  // a hand is 280 px long
        m.scan.keypointsFound = found;
        const auto before = m.fit.poses;
        ASSERT_TRUE(fitFingers(knownBody(), m.scan, m.hands, m.fit));
        const double mm = tipsMm(m.fit.poses, m.truth).second;
        if (found)
            EXPECT_LT(mm, 10);
        else
            EXPECT_EQ(mm, tipsMm(before, m.truth).second);
    }
}

TEST(FitFingers, wrongListsAndNumbersAreRefused) {
    Made m = make(0.5, 1);
    m.hands[3].pop_back();
    EXPECT_EQ(fitFingers(knownBody(), m.scan, m.hands, m.fit).error().code, Code::InvalidArgument);
    m.hands[3].push_back({{NAN, 0}, 1});
    EXPECT_EQ(fitFingers(knownBody(), m.scan, m.hands, m.fit).error().code, Code::CorruptData);
    m.hands.pop_back();
    EXPECT_EQ(fitFingers(knownBody(), m.scan, m.hands, m.fit).error().code, Code::InvalidArgument);
}

}  // namespace
}  // namespace dpl
