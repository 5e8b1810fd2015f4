// SPDX-License-Identifier: Apache-2.0
// Motion modes: what a state holds, and that it forgets exactly and never grows.
#include "sdk/avatar/motion_state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sdk/avatar/pose_correctives.h"
#include "tests/not_finite.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

const Vec3f kAxis = glm::normalize(Vec3f(1, 2, -1));

/** Two joints whose still pose is half a radian about kAxis, held for 1.5, 6 and 60 s, in one group. One column a feature. */
MotionModeData twoJoints(std::vector<float> holds = {1.5f, 6, 60}, std::vector<float> lags = {}) {
    MotionModeData m;
    m.joints = {0, 1}, m.movedFromRad = 0.1f, m.movedToRad = 0.3f, m.holdsS = std::move(holds), m.lagsS = std::move(lags);
    const Quatf still = glm::angleAxis(0.5f, kAxis);
    m.still.assign(2, Vec4f(still.x, still.y, still.z, still.w));
    m.rangeRad = {{0.05f, 1.0f}, {0.2f, 0.5f}};
    const size_t features = m.featureCount();
    m.groups = {{.columnCount = uint32_t(features)}}, m.modes.assign(features * features, 0.0f);
    for (size_t i = 0; i < features; ++i) m.modes[i * features + i] = 1;
    return m;
}

/** Joints turned by so many radians from their still pose, by quaternions of any length and sign. */
Pose turnedBy(float first, float second) {
    Pose pose = Pose::rest(2);
    const Quatf still = glm::angleAxis(0.5f, kAxis);
    pose.localRotations[0] = -3.0f * (glm::angleAxis(first, Vec3f(0, 1, 0)) * still);
    pose.localRotations[1] = 0.1f * (glm::angleAxis(second, Vec3f(0, 0, 1)) * still);
    return pose;
}

std::vector<float> coefficientsOf(const MotionModeData& m, const MotionState& state) {
    std::vector<float> k(m.columnCount(), 7.0f);
    motionCoefficients(m, state, k);
    return k;
}

std::vector<float> settled(const MotionModeData& m, const Pose& pose) {
    return coefficientsOf(m, stateOf(m, pose));
}

/** The state `seconds` later, in `pose`. */
void advance(const MotionModeData& m, Pose pose, double seconds, MotionState& state) {
    pose.before = forgetMotion(m, state, seconds);
    state = stateOf(m, pose);
}

Pose randomPose(std::mt19937& random) {
    std::normal_distribution<float> normal;
    Pose pose = Pose::rest(2);
    for (Quatf& q : pose.localRotations) q = Quatf(normal(random), normal(random), normal(random), normal(random));
    return pose;
}

TEST(MotionState, isZeroInTheStillPose) {
    const MotionModeData m = twoJoints();
    for (const float k : settled(m, turnedBy(0, 0))) EXPECT_EQ(k, 0);
    for (const float k : settled(m, turnedBy(0.04f, -0.06f))) EXPECT_EQ(k, 0) << "within what still frames stray";
}

TEST(MotionState, risesWithTheAngleUpToItsMost) {
    const MotionModeData m = twoJoints({0});
    std::vector<float> last = settled(m, turnedBy(0, 0));
    for (float angle = 0.02f; angle < 3; angle += 0.02f) {
        const std::vector<float> now = settled(m, turnedBy(angle, -angle));
        for (size_t i = 0; i < now.size(); ++i) EXPECT_GE(now[i], last[i] - 1e-6f) << angle;
        last = now;
    }
    EXPECT_EQ(last[0], 1.0f);
    EXPECT_FLOAT_EQ(last[1], 1.0f);
    EXPECT_FLOAT_EQ(last[2], 0.5f);
    EXPECT_NEAR(settled(m, turnedBy(0.7f, 0))[1], 0.65f, 1e-6f);
    EXPECT_NEAR(settled(m, turnedBy(0.2f, 0))[0], 0.5f, 1e-5f) << "half way from 0.1 to 0.3";
}

TEST(MotionState, aGroupIsShortenedToItsReach) {
    MotionModeData m = twoJoints({0});
    m.groups = {{.columnCount = 1}, {.columnCount = 2, .reach = 0.15f}};
    EXPECT_EQ(settled(m, turnedBy(1, 0)), (std::vector<float>{1, 0.15f, 0}));
    const std::vector<float> both = settled(m, turnedBy(1, 0.6f));
    EXPECT_EQ(both[0], 1.0f) << "another group";
    EXPECT_NEAR(std::hypot(both[1], both[2]), 0.15, 1e-6);
    EXPECT_NEAR(both[2] / both[1], 0.4 / 0.95, 1e-5);
    EXPECT_NEAR(settled(m, turnedBy(0.15f, 0))[1], 0.1, 1e-6) << "within reach";
}

TEST(MotionState, headingTwiceAroundIsNoAngleAboveAHalfTurn) {
    const MotionModeData m = twoJoints({0});
    EXPECT_NEAR(settled(m, turnedBy(6.2831853f + 0.3f, 0))[1], 0.25f, 1e-5f);
    EXPECT_NEAR(settled(m, turnedBy(6.2831853f - 0.3f, 0))[1], 0.25f, 1e-5f);
}

TEST(MotionState, holdsThePeakAndForgetsItByItsTime) {
    const MotionModeData m = twoJoints();
    MotionState state;
    advance(m, turnedBy(0.65f, 0), 0.01, state);
    const std::vector<float> peak = coefficientsOf(m, state);
    advance(m, turnedBy(0, 0), 3, state);
    const std::vector<float> after = coefficientsOf(m, state);
    for (size_t h = 0; h < 3; ++h)
        for (size_t i = 0; i < 2; ++i) EXPECT_NEAR(after[3 * h + i] / peak[3 * h + i], std::exp(-3 / m.holdsS[h]), 1e-5) << h;
    for (const float k : settled(m, turnedBy(0, 0))) EXPECT_EQ(k, 0);
}

TEST(MotionState, aHoldOfZeroIsTheSettledState) {
    const MotionModeData m = twoJoints({0});
    std::mt19937 random(5);
    MotionState state;
    for (int i = 0; i < 1000; ++i) {
        const Pose pose = randomPose(random);
        advance(m, pose, 0.01 * (i % 7), state);
        EXPECT_EQ(coefficientsOf(m, state), settled(m, pose));
    }
}

TEST(MotionState, anyRateForgetsAlike) {
    const MotionModeData m = twoJoints();
    MotionState slow, fast;
    slow = fast = stateOf(m, turnedBy(0.9f, 0.4f));
    for (int i = 0; i < 3; ++i) advance(m, turnedBy(0.1f, 0), 1, slow);
    for (int i = 0; i < 3000; ++i) advance(m, turnedBy(0.1f, 0), 1e-3, fast);
    const std::vector<float> a = coefficientsOf(m, slow), b = coefficientsOf(m, fast);
    for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-6) << i;
}

TEST(MotionState, aPoseTwiceForOneTimeChangesNothing) {
    const MotionModeData m = twoJoints();
    std::mt19937 random(6);
    MotionState state;
    for (int i = 0; i < 100; ++i) {
        const Pose pose = randomPose(random);
        advance(m, pose, 0.1, state);
        const MotionState once = state;
        advance(m, pose, 0, state);
        EXPECT_EQ(once, state);
    }
}

TEST(MotionState, timeThatRunsBackwardsSettles) {
    const MotionModeData m = twoJoints();
    for (const double seconds : {-1e-9, -3600.0, double(kNan), double(kInfinity), -double(kInfinity)}) {
        MotionState state = stateOf(m, turnedBy(1, 1));
        advance(m, turnedBy(0.2f, 0), seconds, state);
        EXPECT_EQ(state, stateOf(m, turnedBy(0.2f, 0))) << seconds;
    }
    MotionState hour = stateOf(m, turnedBy(1, 1));
    advance(m, turnedBy(0.2f, 0), 3600, hour);
    const MotionState want = stateOf(m, turnedBy(0.2f, 0));
    for (size_t i = 0; i < hour.held.size(); ++i) EXPECT_NEAR(hour.held[i], want.held[i], 1e-20) << "an hour is for ever";
}

TEST(MotionState, aLagFollowsAndComesToRest) {
    const MotionModeData m = twoJoints({0}, {0.5f});
    const size_t first = m.heldCount();
    MotionState state = stateOf(m, turnedBy(0, 0));
    for (size_t i = first; i < m.featureCount(); ++i)
        EXPECT_EQ(coefficientsOf(m, state)[i], 0) << "nothing lags behind a pose that was held";
    advance(m, turnedBy(0.6f, 0), 0, state);
    const std::vector<float> jump = coefficientsOf(m, state);
    EXPECT_GT(std::abs(jump[first + 2]), 0.3f) << "the pose of a moment later: the whole turn is still to come";
    advance(m, turnedBy(0.6f, 0), 1, state);
    const std::vector<float> later = coefficientsOf(m, state);
    for (size_t i = first; i < jump.size(); ++i) EXPECT_NEAR(later[i], std::exp(-2) * jump[i], 1e-6) << i;
}

/** The lag of a turn that goes evenly, at any rate: u = rt, y = r (t - tau (1 - exp(-t/tau))). */
TEST(MotionState, aLagIsExactWhereTurnsGoEvenly) {
    const MotionModeData m = twoJoints({0}, {0.15f, 1});
    Pose pose = turnedBy(0, 0);
    const MotionState start = stateOf(m, pose);
    for (const int steps : {1, 7, 1000}) {
        MotionState state = start;
        for (int k = 1; k <= steps; ++k) {  // the six numbers themselves go evenly, not the angle: any will do
            MotionMemory left = forgetMotion(m, state, 2.0 / steps);
            state = stateOf(m, pose);
            for (size_t i = 0; i < 12; ++i) state.turns[i] = start.turns[i] + 0.1 * k / steps;
            for (size_t i = 0; i < 24; ++i) state.lagged[i] = left.lagged[i] + (1 - left.earlier[i / 12]) * state.turns[i % 12];
        }
        for (size_t l = 0; l < 2; ++l) {
            const double tau = double(m.lagsS[l]), want = 0.05 * (2 - tau * (1 - std::exp(-2 / tau)));
            for (size_t i = 0; i < 12; ++i) EXPECT_NEAR(state.lagged[12 * l + i] - start.lagged[i], want, 1e-12) << steps;
        }
    }
}

TEST(MotionState, whatIsCarriedAcrossAJumpIsTheLagAndNotTheJump) {
    const MotionModeData m = twoJoints({0, 6}, {0.5f});
    MotionState state = stateOf(m, turnedBy(0, 0));
    advance(m, turnedBy(0.9f, 0), 0.2, state);
    const std::vector<float> before = coefficientsOf(m, state);
    Pose pose = turnedBy(0, 0);
    pose.before = carryMotion(m, state);
    const std::vector<float> after = coefficientsOf(m, stateOf(m, pose));
    for (size_t i = m.inputCount(); i < after.size(); ++i) EXPECT_NEAR(after[i], before[i], 1e-6) << i;
}

TEST(MotionState, neverGrowsWhileThePoseRests) {
    const MotionModeData m = twoJoints({1.5f, 6, 60}, {0.15f, 0.4f, 1});
    std::mt19937 random(7);
    MotionState state;
    std::vector<double> now(m.featureCount()), before(m.featureCount());
    for (int i = 0; i < 250000; ++i) {
        const Pose pose = randomPose(random);
        advance(m, pose, i % 3 == 0 ? 1e-9 : 0.02, state);
        motionFeatures(m, state, before);
        for (int rest = 0; rest < 3; ++rest) {
            advance(m, pose, rest == 0 ? 1e-3 : 1.0, state);
            motionFeatures(m, state, now);
            for (size_t f = 0; f < now.size(); ++f) ASSERT_LE(std::abs(now[f]), std::abs(before[f]) + 1e-15) << f;
            before = now;
        }
        for (const double held : state.held) ASSERT_GE(held, 0);
        for (const double lagged : state.lagged) ASSERT_LE(std::abs(lagged), 2 + 1e-12);
    }
}

TEST(MotionState, aSpinThatStopsDeadSwingsOutAndComesToRest) {
    const MotionModeData m = twoJoints({0}, {0.15f, 0.4f, 1});
    MotionState state = stateOf(m, turnedBy(0, 0));
    for (int frame = 1; frame <= 200; ++frame) advance(m, turnedBy(float(frame) * 0.08f, 0), 1.0 / 90, state);  // over a turn a second
    const Pose stopped = turnedBy(200 * 0.08f, 0);
    std::vector<double> now(m.featureCount()), before(m.featureCount());
    motionFeatures(m, state, before);
    double lag = 0;
    for (size_t i = m.heldCount(); i < before.size(); ++i) lag = std::max(lag, std::abs(before[i]));
    EXPECT_GT(lag, 0.3) << "the cloth is still on its way";
    for (int frame = 0; frame < 900; ++frame) {
        advance(m, stopped, 1.0 / 90, state);
        motionFeatures(m, state, now);
        for (size_t i = m.heldCount(); i < now.size(); ++i)
            ASSERT_LE(std::abs(now[i]), std::abs(before[i]) + 1e-15) << "frame " << frame << ": it passes its place";
        before = now;
    }
    for (size_t i = m.heldCount(); i < now.size(); ++i) EXPECT_NEAR(now[i], 0, 1e-4);
}

TEST(MotionState, aWalkAfterAnHourOfStandingIsThatOfSomebodyWhoNeverMoved) {
    const MotionModeData m = twoJoints({1.5f, 6, 60}, {0.15f, 1});
    MotionState rested = stateOf(m, turnedBy(0, 0)), fresh = rested;
    advance(m, turnedBy(0.9f, 0.7f), 0.5, rested);
    advance(m, turnedBy(0, 0), 0.5, rested);
    EXPECT_NE(coefficientsOf(m, rested), coefficientsOf(m, fresh)) << "something is remembered at first";
    for (int minute = 0; minute < 60; ++minute) advance(m, turnedBy(0, 0), 60, rested);
    for (int frame = 0; frame < 120; ++frame) {
        const Pose step = turnedBy(0.6f * std::sin(0.1f * float(frame)), 0.4f * std::cos(0.1f * float(frame)));
        advance(m, step, 1.0 / 60, rested), advance(m, step, 1.0 / 60, fresh);
        const std::vector<float> a = coefficientsOf(m, rested), b = coefficientsOf(m, fresh);
        for (size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-6) << "frame " << frame;
    }
}

TEST(MotionState, stifferClothesMoveLessAndSofterOnesALittleBeyondTheReach) {
    MotionModeData m = twoJoints();
    for (MotionGroupData& group : m.groups) group.reach = 1e6f;
    const MotionState state = stateOf(m, turnedBy(1, -0.8f));
    const auto with = [&](float stiffness) {
        std::vector<float> k(m.columnCount());
        motionCoefficients(m, state, k, stiffness);
        return k;
    };
    const std::vector<float> learned = with(1);
    EXPECT_EQ(learned, coefficientsOf(m, state)) << "the same bytes";
    for (size_t i = 0; i < learned.size(); ++i) {
        EXPECT_FLOAT_EQ(with(3)[i], 0.5f * learned[i]);
        EXPECT_FLOAT_EQ(with(0)[i], 2 * learned[i]);
        EXPECT_LT(std::abs(with(kMostClothStiffness)[i]), 0.02f * std::abs(learned[i]) + 1e-12f);
    }
    for (MotionGroupData& group : m.groups) group.reach = 1e-3f;  // all are shortened to it
    size_t column = 0;
    for (const MotionGroupData& group : m.groups) {
        double soft = 0, asLearned = 0;
        for (size_t c = 0; c < group.columnCount; ++c, ++column)
            soft += std::pow(double(with(0)[column]), 2), asLearned += std::pow(double(with(1)[column]), 2);
        EXPECT_NEAR(std::sqrt(asLearned), 1e-3, 1e-9);
        EXPECT_NEAR(std::sqrt(soft), kMostMotionOverReach * 1e-3, 1e-9);
    }
}

TEST(MotionState, correctivesAppendTheSettledColumnsAndDoNotFadeThem) {
    AvatarData avatar = test::layeredAvatar(3, 0, 12, 4);
    avatar.correctives = test::randomCorrectives(avatar, 3, {.modes = 4, .reach = 0.01f, .reachOffModes = 0.01f, .motion = 3});
    const PoseCorrectiveData& c = avatar.correctives;
    ASSERT_TRUE(checkCorrectives(c, 12, avatar.mesh.restPositions.size()));
    Pose pose = Pose::rest(12);
    pose.localRotations[4] = glm::angleAxis(1.2f, kAxis);
    std::vector<float> k;
    correctiveCoefficients(c, pose, k);
    ASSERT_EQ(k.size(), 7u);
    EXPECT_EQ(std::vector<float>(k.begin() + 4, k.end()), settled(c.motion, pose));
    Pose remembering = pose;
    remembering.before.held.fill(0.9);
    remembering.before.lagged.fill(0.3);
    std::vector<float> held;
    correctiveCoefficients(c, remembering, held);
    EXPECT_TRUE(std::equal(k.begin(), k.begin() + 4, held.begin())) << "modes of the pose remember nothing";
    EXPECT_EQ(std::vector<float>(held.begin() + 4, held.end()), settled(c.motion, remembering));
    EXPECT_NE(held, k);
    std::vector<Vec4f> nodes;
    correctiveNodes(c, k, nodes);
    for (uint32_t n = 0; n < c.nodeCount; ++n) {
        Vec4f sum(0);
        for (uint32_t i = 0; i < 7; ++i) sum += k[i] * c.nodes[n * 7 + i];
        EXPECT_LT(glm::length(sum - nodes[n]), 1e-6f);
    }
}

}  // namespace
}  // namespace dpl
