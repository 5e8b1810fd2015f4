// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "sdk/motion/clip.h"

namespace dpl {
namespace {

const std::vector<JointData> kJoints = {{"root", -1, {0, 1, 0}, {}}, {"tip", 0, {0, 2, 0}, {}}};

ClipData quarterTurn() {
    ClipData clip;
    clip.name = "turn";
    clip.timesS = {10.0f, 11.0f};
    clip.channels = {
        {1,
         {Quatf(1, 0, 0, 0), -glm::angleAxis(glm::half_pi<float>(), Vec3f(0, 0, 1))}}};  // negated: plain slerp would take the longer arc
    clip.rootTranslations = {{0, 0, 0}, {0, 0, 2}};
    return clip;
}

TEST(Clip, samplesHalfwayAlongTheShorterArc) {
    const ClipData clip = quarterTurn();
    ASSERT_TRUE(checkClip(clip, kJoints));
    EXPECT_DOUBLE_EQ(clipDurationS(clip), 1.0);
    const Pose pose = samplePose(clip, kJoints, 0.5);
    const Vec3f x = pose.localRotations[1] * Vec3f(1, 0, 0);
    EXPECT_NEAR(x.x, std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(x.y, std::sqrt(0.5), 1e-6);
    EXPECT_EQ(pose.localRotations[0], Quatf(1, 0, 0, 0));
    EXPECT_FLOAT_EQ(pose.rootTranslation.z, 1.0f);
}

TEST(Clip, holdsBeyondItsEndsAndAtStrangeTimes) {
    const ClipData clip = quarterTurn();
    for (const double t : {-5.0, 0.0, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_FLOAT_EQ(samplePose(clip, kJoints, t).rootTranslation.z, 0.0f);
    for (const double t : {1.0, 7.0, 1e300}) EXPECT_FLOAT_EQ(samplePose(clip, kJoints, t).rootTranslation.z, 2.0f);
}

TEST(Clip, refusesWhatDoesNotFitTheRig) {
    const auto broken = [](auto&& change) {
        ClipData clip = quarterTurn();
        change(clip);
        return !checkClip(clip, kJoints);
    };
    EXPECT_TRUE(broken([](ClipData& c) { c.timesS = {1, 1}; }));
    EXPECT_TRUE(broken([](ClipData& c) { c.timesS = {}; }));
    EXPECT_TRUE(broken([](ClipData& c) { c.timesS[1] = std::numeric_limits<float>::quiet_NaN(); }));
    EXPECT_TRUE(broken([](ClipData& c) { c.channels[0].joint = 2; }));
    EXPECT_TRUE(broken([](ClipData& c) { c.channels.push_back(c.channels[0]); }));
    EXPECT_TRUE(broken([](ClipData& c) { c.channels[0].rotations.pop_back(); }));
    EXPECT_TRUE(broken([](ClipData& c) { c.channels[0].rotations[0] = Quatf(0, 0, 0, 0); }));
    EXPECT_TRUE(broken([](ClipData& c) { c.rootTranslations.pop_back(); }));
    EXPECT_TRUE(broken([](ClipData& c) { c.rootTranslations[0].x = std::numeric_limits<float>::infinity(); }));
}

}  // namespace
}  // namespace dpl
