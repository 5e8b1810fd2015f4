// SPDX-License-Identifier: Apache-2.0
// What clothes remember: along an app's time stamps, and along a clip in any order of calls.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "sdk/motion/clip.h"
#include "sdk/motion/clip_memory.h"
#include "sdk/motion/motion_clock.h"

namespace dpl {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

std::vector<JointData> twoJoints() {
    std::vector<JointData> joints(2);
    joints[1].parent = 0;
    return joints;
}

/** Both joints: held for 0, 1.5 and 6 s, and with lags of 0.15 and 1 s. One column, of everything. */
MotionModeData modes() {
    MotionModeData m;
    m.joints = {0, 1}, m.still.assign(2, Vec4f(0, 0, 0, 1)), m.rangeRad.assign(2, Vec2f(0.05f, 1.5f));
    m.movedFromRad = 0.1f, m.movedToRad = 0.3f, m.holdsS = {0, 1.5f, 6}, m.lagsS = {0.15f, 1};
    m.groups = {{.columnCount = 1, .reach = 10}}, m.modes.assign(m.featureCount(), 1.0f);
    return m;
}

Pose turned(double angle) {
    Pose pose = Pose::rest(2);
    pose.localRotations[1] = glm::angleAxis(float(angle), Vec3f(1, 0, 0));
    return pose;
}

/** Both joints swing, at 30 keys a second. */
ClipData swing(double seconds) {
    ClipData clip;
    clip.channels.resize(2);
    for (uint32_t j = 0; j < 2; ++j) clip.channels[j].joint = j;
    for (int k = 0; k <= int(seconds * 30 + 0.5); ++k) {
        const double t = k / 30.0;
        clip.timesS.push_back(float(t));
        clip.channels[0].rotations.push_back(glm::angleAxis(float(0.8 * std::sin(3 * t)), Vec3f(0, 1, 0)));
        clip.channels[1].rotations.push_back(glm::angleAxis(float(std::max(0.0, std::sin(1.3 * t))), Vec3f(1, 0, 0)));
    }
    return clip;
}

class MotionClockTest : public ::testing::Test {
protected:
    /** What a pose of this angle holds when it is shown at a time. */
    MotionMemory at(double angle, int64_t timeNs) {
        pose_ = turned(angle);
        clock_.setTime(timeNs);
        clock_.show(motion_, pose_);
        return pose_.before;
    }
    std::vector<float> coefficients(const Pose& pose) const {
        std::vector<float> k(motion_.columnCount());
        motionCoefficients(motion_, stateOf(motion_, pose), k);
        return k;
    }
    double peak(const MotionMemory& state, size_t hold) const { return state.held[hold * motion_.inputCount() + 2]; }

    const MotionModeData motion_ = modes();
    MotionClock clock_;
    Pose pose_;
};

TEST_F(MotionClockTest, holdsAPeakByTheTimeThatPassed) {
    at(1.05, kSecond);
    const MotionMemory later = at(0, 3 * kSecond);
    EXPECT_EQ(peak(later, 0), 0);
    EXPECT_NEAR(peak(later, 1), std::exp(-2 / 1.5), 1e-6);
    EXPECT_NEAR(peak(later, 2), std::exp(-2 / 6.0), 1e-6);
}

TEST_F(MotionClockTest, aPoseTwiceForOneTimeAndSeveralBetweenPicturesChangeNothing) {
    at(1, kSecond);
    const MotionMemory once = at(0.2, 2 * kSecond);
    EXPECT_EQ(at(0.2, 2 * kSecond), once);
    EXPECT_EQ(at(0.7, 2 * kSecond), once) << "another pose for the same time";
    EXPECT_EQ(at(0.2, 2 * kSecond), once) << "and the peak of the pose that it replaced is gone";
    clock_.setTime(5 * kSecond / 2);
    clock_.setTime(3 * kSecond);  // the pose for 2.5 s was never shown
    pose_ = turned(0);
    clock_.show(motion_, pose_);
    EXPECT_NEAR(peak(pose_.before, 2), 0.95 * std::exp(-2 / 6.0), 1e-6);
}

TEST_F(MotionClockTest, everyRateRemembersAlike) {
    std::vector<MotionState> ends;
    for (const int hz : {30, 72, 90, 120, 1000}) {
        clock_.settle(pose_);
        for (int frame = 0; frame <= 4 * hz; ++frame) at(1 - 0.25 * double(frame) / hz, kSecond + frame * kSecond / hz);
        ends.push_back(stateOf(motion_, pose_));
    }
    for (const MotionState& end : ends) {
        for (size_t i = 0; i < end.held.size(); ++i)  // "has moved" falls between two pictures, of which a fast rate sees more
            EXPECT_NEAR(end.held[i], ends[0].held[i], 1e-3) << i;
        for (size_t i = 0; i < end.lagged.size(); ++i) EXPECT_NEAR(end.lagged[i], ends[0].lagged[i], 2e-4) << i;
    }
    EXPECT_GT(ends[0].held[8], 0.4);
    EXPECT_GT(std::abs(ends[0].lagged[12 + 11] - ends[0].turns[11]), 0.01) << "a lag of 1 s is still under way";
}

TEST_F(MotionClockTest, onePictureASecondHoldsWhatItSaw) {
    for (int second = 0; second <= 4; ++second) at(second == 0 ? 1.05 : 0.0, second * kSecond);
    EXPECT_NEAR(peak(pose_.before, 2), std::exp(-4 / 6.0), 1e-6);
}

TEST_F(MotionClockTest, whatHappensDuringAFadeIsHeld) {
    at(0.5, 0), at(0, -kSecond);
    at(1.05, -kSecond + kSecond / 10);
    at(0, -kSecond + kSecond / 5);
    EXPECT_NEAR(peak(at(0, kSecond / 5), 2), std::exp(-1.1 / 6), 1e-6);
}

TEST_F(MotionClockTest, jumpsAndGapsFadeWithinAQuarterOfASecondWithoutAStep) {
    for (const int64_t jump : {int64_t(-1), -kSecond, 6 * kSecond, 3600 * kSecond, -3600 * kSecond, INT64_MAX / 2}) {
        clock_.settle(pose_);
        at(1, 0), at(0, kSecond / 100);
        const double before = peak(pose_.before, 2);
        const MotionMemory after = at(0, kSecond / 100 + jump);
        EXPECT_NEAR(peak(after, 2), before, 1e-9) << jump << ": the picture after a jump shows no step";
        double last = before;
        for (int frame = 1; frame <= 25; ++frame) {
            const double now = peak(at(0, kSecond / 100 + jump + frame * kSecond / 100), 2);
            EXPECT_LT(now, last) << jump;
            EXPECT_GT(now, last - 0.05 * before) << jump;
            last = now;
        }
        EXPECT_EQ(last, 0) << jump;
    }
}

TEST_F(MotionClockTest, aPoseWithoutATimeHoldsNothingAndKeepsWhatAClipGave) {
    at(1, kSecond);
    Pose plain = turned(0.1);
    clock_.setUntimed();
    clock_.show(motion_, plain);
    EXPECT_EQ(plain.before, MotionMemory());
    plain.before.held[5] = 0.5;
    clock_.show(motion_, plain);
    EXPECT_EQ(plain.before.held[5], 0.5);
    EXPECT_NEAR(peak(at(0.1, 7 * kSecond), 1), 0.5, 1e-9) << "the next pose with a time goes on from what was shown";
}

TEST_F(MotionClockTest, savedAndRestoredItGoesOnWithTheSameBytes) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> angle(0, 2);
    MotionClock other;
    Pose restored;
    for (int frame = 0; frame < 200; ++frame) {
        at(angle(random), frame * kSecond / 72);
        if (frame == 90) {
            const std::vector<uint8_t> bytes = clock_.save(motion_);
            EXPECT_LE(bytes.size(), kMaxSavedMotionBytes);
            ASSERT_TRUE(other.restore(motion_, bytes, restored));
            EXPECT_EQ(restored.before, pose_.before);
        }
        if (frame <= 90) continue;
        restored = pose_;
        restored.before = {};
        other.setTime(frame * kSecond / 72);
        other.show(motion_, restored);
        ASSERT_EQ(restored.before, pose_.before) << frame;
    }
}

TEST_F(MotionClockTest, refusesForeignAndImpossibleStates) {
    at(1, kSecond);
    const std::vector<uint8_t> good = clock_.save(motion_);
    Pose pose = turned(0);
    MotionClock clock;
    const auto refusal = [&](std::vector<uint8_t> bytes) {
        const Status status = clock.restore(motion_, bytes, pose);
        EXPECT_FALSE(status);
        EXPECT_EQ(pose.before, MotionMemory());
        return status ? std::string() : status.error().message;
    };
    EXPECT_NE(refusal({}).find("no motion state"), std::string::npos);
    EXPECT_NE(refusal(std::vector<uint8_t>(good.begin(), good.end() - 1)).find("bytes"), std::string::npos);
    for (size_t byte = 0; byte < good.size(); ++byte) {  // damage never crashes, and never gives a number that is not finite
        std::vector<uint8_t> bad = good;
        bad[byte] ^= 0x80;
        Pose shown = turned(0);
        if (!clock.restore(motion_, bad, shown)) continue;
        for (const double k : coefficients(shown)) EXPECT_TRUE(std::isfinite(k)) << byte;
    }
    std::vector<uint8_t> huge = good;
    const double billion = 1e9;
    std::memcpy(huge.data() + huge.size() - sizeof billion, &billion, sizeof billion);
    EXPECT_NE(refusal(huge).find("no motion gives"), std::string::npos);
    MotionModeData another = motion_;
    another.holdsS[2] = 7;
    EXPECT_NE(clock.restore(another, good, pose).error().message.find("another avatar"), std::string::npos);
    EXPECT_TRUE(clock.restore(MotionModeData(), MotionClock().save(MotionModeData()), pose)) << "an avatar without motion modes";
}

TEST_F(MotionClockTest, anAvatarWithoutMotionModesRemembersNothing) {
    Pose pose = turned(1);
    clock_.setTime(0), clock_.show(MotionModeData(), pose);
    clock_.setTime(kSecond), clock_.show(MotionModeData(), pose);
    EXPECT_EQ(pose.before, MotionMemory());
}

TEST(ClipMemory, anyOrderOfCallsGivesTheSameBytes) {
    const std::vector<JointData> joints = twoJoints();
    const MotionModeData motion = modes();
    const ClipData clip = swing(7.3);
    ClipMemory played(clip, joints, motion), sought(clip, joints, motion);
    std::vector<double> times;
    for (double t = -0.5; t < 9; t += 0.0173) times.push_back(t);
    std::vector<MotionMemory> once;
    for (const double t : times) once.push_back(played.at(t, false));
    std::mt19937 random(4);
    std::vector<size_t> order(times.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), random);
    for (const size_t i : order) {
        ASSERT_EQ(sought.at(times[i], false), once[i]) << times[i];
        const MotionMemory loop = sought.at(times[i], true);  // between two calls for the same clip
        for (size_t k = 0; k < loop.held.size(); ++k) ASSERT_GE(loop.held[k], once[i].held[k]);
    }
}

TEST(ClipMemory, agreesWithAPlainReplay) {
    const std::vector<JointData> joints = twoJoints();
    const MotionModeData motion = modes();
    const ClipData clip = swing(5);
    ClipMemory memory(clip, joints, motion);
    MotionState state;
    Pose pose;
    for (int step = 0; step <= 5000; ++step) {
        samplePose(clip, joints, step * 1e-3, pose);
        pose.before = forgetMotion(motion, state, step == 0 ? 0 : 1e-3);
        state = stateOf(motion, pose);
        pose.before = memory.at(step * 1e-3, false);
        const MotionState got = stateOf(motion, pose);
        for (size_t i = 0; i < got.held.size(); ++i) ASSERT_NEAR(got.held[i], state.held[i], 0.01) << step << ' ' << i;
        for (size_t i = 0; i < got.lagged.size(); ++i) ASSERT_NEAR(got.lagged[i], state.lagged[i], 0.002) << step << ' ' << i;
    }
    EXPECT_GT(state.held[8], 0.3) << "the joint's peak in the hold of 6 s";
    EXPECT_GT(std::abs(state.lagged[12 + 11] - state.turns[11]), 0.01);
}

TEST(ClipMemory, aLoopBeginsAsItEnds) {
    const std::vector<JointData> joints = twoJoints();
    const MotionModeData motion = modes();
    const ClipData clip = swing(0.5);
    ClipMemory memory(clip, joints, motion);
    MotionState state;  // of twenty rounds
    Pose pose;
    for (int step = 0; step < 10000; ++step) {
        const double t = std::fmod(step * 1e-3, 0.5);
        samplePose(clip, joints, t, pose);
        pose.before = forgetMotion(motion, state, 1e-3);
        state = stateOf(motion, pose);
        if (step < 9500) continue;
        pose.before = memory.at(t, true);
        const MotionState got = stateOf(motion, pose);
        for (size_t i = 0; i < got.held.size(); ++i) ASSERT_NEAR(got.held[i], state.held[i], 0.02) << t << ' ' << i;
        for (size_t i = 0; i < got.lagged.size(); ++i) ASSERT_NEAR(got.lagged[i], state.lagged[i], 0.01) << t << ' ' << i;
    }
}

TEST(ClipMemory, clipsOfOnePoseAndOfNoKnownTimeHoldNothing) {
    const std::vector<JointData> joints = twoJoints();
    const MotionModeData motion = modes(), none;
    ClipData one = swing(0);
    ASSERT_EQ(one.timesS.size(), 1u);
    ClipMemory memory(one, joints, motion);
    EXPECT_EQ(memory.at(0, false), MotionMemory());
    for (const bool loop : {false, true})
        for (const double lagged : memory.at(0, loop).lagged) EXPECT_TRUE(std::isfinite(lagged));
    const ClipData clip = swing(2);
    ClipMemory forgetful(clip, joints, none);
    EXPECT_EQ(forgetful.at(1, true), MotionMemory());
    EXPECT_EQ(ClipMemory(clip, joints, motion).at(std::numeric_limits<double>::quiet_NaN(), false), MotionMemory());
}

TEST(ClipMemory, afterItsEndAClipIsForgotten) {
    const std::vector<JointData> joints = twoJoints();
    const MotionModeData motion = modes();
    const ClipData clip = swing(3);
    ClipMemory memory(clip, joints, motion);
    const MotionMemory end = memory.at(3, false), later = memory.at(9, false);
    for (size_t i = 6; i < 9; ++i) EXPECT_NEAR(later.held[i], std::exp(-1.0) * std::max(end.held[i], 0.0), 0.02) << i;
    for (const double held : memory.at(1e9, false).held) EXPECT_LT(held, 1e-9);
}

TEST(ClipMemory, aClipOfDaysTakesBoundedMemory) {
    const std::vector<JointData> joints = twoJoints();
    const MotionModeData motion = modes();
    ClipData clip = swing(1);
    clip.timesS.back() = 1e6f;
    ClipMemory memory(clip, joints, motion);
    for (const double t : {0.5, 5e5, 9.9e5})
        for (const double held : memory.at(t, true).held) EXPECT_TRUE(held >= 0 && held <= 1.5);
}

}  // namespace
}  // namespace dpl
