// SPDX-License-Identifier: Apache-2.0
// Retargeted people look ahead and stand still on their feet. Prints degrees and millimetres.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sdk/motion/plant_feet.h"
#include "sdk/motion/retarget.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/motion/mocap.h"

namespace dpl {
namespace {

using test::jointOf;
using test::personRig;
using test::positionsAt;

/** Degrees by which the head points up, the median over a clip. */
float headPitchDeg(const ClipData& clip, const std::vector<JointData>& rig) {
    std::vector<float> pitch;
    std::vector<Mat3x4f> g;
    for (const float t : clip.timesS) {
        jointTransforms(rig, samplePose(clip, rig, double(t)), g);
        pitch.push_back(glm::degrees(std::asin((Mat3f(g[jointOf(rig, "head")]) * Vec3f(0, 0, 1)).y)));
    }
    std::nth_element(pitch.begin(), pitch.begin() + std::ptrdiff_t(pitch.size() / 2), pitch.end());
    return pitch[pitch.size() / 2];
}

/** Horizontal movement of the balls of the feet in each stance, mm: left and right, sorted. The stances are those of the recording: its
 * ball is slower than 0.35 m/s and at most 8 cm above its lowest place, for 0.05 s or longer. */
std::vector<float> slidesMm(const Motion& motion, const ClipData& clip, const std::vector<JointData>& rig) {
    std::vector<JointData> source = motion.joints;
    assignHumanoidBones(source);
    std::vector<std::vector<Vec3f>> from(motion.keyCount()), at;
    std::vector<Quatf> rotations;
    for (size_t k = 0; k < from.size(); ++k) motionAt(motion, k, rotations, from[k]);
    for (const float t : clip.timesS) at.push_back(positionsAt(clip, rig, double(t)));
    const size_t dropped = from.size() - at.size();  // the lead-in
    std::vector<float> slides;
    for (const std::string side : {"left", "right"}) {
        const size_t ball = jointOf(rig, side + "Toes"), foot = jointOf(source, side + "Foot");
        size_t joint = foot + 1;  // toes or the end site of the foot
        while (source[joint].parent != int32_t(foot)) ++joint;
        float floor = 1e9f;
        for (size_t k = dropped; k < from.size(); ++k) floor = std::min(floor, from[k][joint].y);
        const auto stands = [&](size_t k) {
            const size_t a = k < 2 ? 0 : k - 2, b = std::min(k + 2, from.size() - 1);
            return glm::length(from[b][joint] - from[a][joint]) < 0.35f * (motion.timesS[b] - motion.timesS[a]) &&
                   from[k][joint].y < floor + 0.08f;
        };
        for (size_t k = dropped; k < from.size(); ++k) {
            Vec3f low(1e9f), high(-1e9f);
            const size_t begin = k;
            for (; k < from.size() && stands(k); ++k)
                low = glm::min(low, at[k - dropped][ball]), high = glm::max(high, at[k - dropped][ball]);
            if (k > begin && motion.timesS[k - 1] - motion.timesS[begin] >= 0.05f)
                slides.push_back(1000 * std::hypot(high.x - low.x, high.z - low.z));
        }
    }
    std::sort(slides.begin(), slides.end());
    return slides;
}

/** A person who moves ahead at this speed for one second, with the head turned up by this angle. */
Motion glide(const std::vector<JointData>& rig, float metresPerS, float headUpRad) {
    Motion motion;
    motion.name = "glide";
    motion.joints = rig;
    motion.translations.push_back({0, {}});
    for (int k = 0; k <= 60; ++k) {
        motion.timesS.push_back(float(k) / 60);
        for (size_t j = 0; j < rig.size(); ++j)
            motion.rotations.push_back(j == jointOf(rig, "head") ? glm::angleAxis(-headUpRad, Vec3f(1, 0, 0)) : Quatf(1, 0, 0, 0));
        motion.translations[0].offsets.push_back({0, 0, metresPerS * float(k) / 60});
    }
    return motion;
}

TEST(RetargetLooks, headsOfPeopleWhoWalkAreLevelAndOthersStay) {
    const auto rig = personRig(0.8f);
    const float up = glm::radians(24.0f);
    RetargetOptions asRecorded;
    asRecorded.levelHead = false;
    const auto exact = retarget(glide(rig, 1.2f, up), rig, asRecorded), walks = retarget(glide(rig, 1.2f, up), rig),
               stands = retarget(glide(rig, 0.1f, up), rig), strange = retarget(glide(rig, 1.2f, glm::radians(60.0f)), rig);
    ASSERT_TRUE(exact && walks && stands && strange);
    EXPECT_NEAR(headPitchDeg(*exact, rig), 24, 0.1);
    EXPECT_NEAR(headPitchDeg(*walks, rig), 0, 0.1);
    EXPECT_NEAR(headPitchDeg(*stands, rig), 24, 0.1) << "who stands may look anywhere";
    EXPECT_NEAR(headPitchDeg(*strange, rig), 60, 0.1) << "no rest pose is as wrong as that";
}

TEST(RetargetLooks, recordedWalkersLookAhead) {
    const auto rig = personRig(0.8f);
    for (const char* name : {"02_01", "02_03", "05_01", "07_01", "09_01"}) {
        SCOPED_TRACE(name);
        NEED_MOCAP(motion, name);
        RetargetOptions asRecorded;
        asRecorded.levelHead = false;
        const auto before = retarget(*motion, rig, asRecorded), after = retarget(*motion, rig);
        ASSERT_TRUE(before && after);
        std::printf("%s: head up by %.1f degrees, levelled %.1f\n", name, double(headPitchDeg(*before, rig)),
                    double(headPitchDeg(*after, rig)));
        EXPECT_LT(std::abs(headPitchDeg(*after, rig)), 1.0f);
    }
}

TEST(RetargetLooks, aFootThatSlidesIsHeldWithItsRotationAndTheHipsHardlySink) {
    const auto rig = personRig(0.8f);
    RetargetOptions asRecorded;
    asRecorded.plantFeet = false;
    const Motion motion = glide(rig, 0.19f, 0);
    const auto before = retarget(motion, rig, asRecorded), after = retarget(motion, rig);
    ASSERT_TRUE(before && after);
    ASSERT_TRUE(checkClip(*after, rig));
    const auto slid = slidesMm(motion, *before, rig), held = slidesMm(motion, *after, rig);
    ASSERT_EQ(slid.size(), 2u) << "both feet stand all the time";
    EXPECT_NEAR(slid.back(), 190, 1);
    EXPECT_LT(held.back(), 0.5f);
    std::vector<Mat3x4f> g;
    jointTransforms(rig, samplePose(*after, rig, 0.0), g);
    EXPECT_NEAR(g[jointOf(rig, "leftFoot")][0][0], 1, 1e-4) << "the foot keeps its rotation";
    for (size_t k = 0; k < after->timesS.size(); ++k) EXPECT_LE(before->rootTranslations[k].y - after->rootTranslations[k].y, 0.0601f);
}

TEST(RetargetLooks, recordedFeetDoNotSlideAndKneesDoNotJump) {
    const auto rig = personRig(0.8f);
    for (const char* name : {"02_01", "02_03", "05_01", "07_01", "scaled_131_01"}) {
        SCOPED_TRACE(name);
        NEED_MOCAP(motion, name);
        RetargetOptions asRecorded;
        asRecorded.plantFeet = false;
        const auto before = retarget(*motion, rig, asRecorded), after = retarget(*motion, rig);
        ASSERT_TRUE(before && after);
        const auto slid = slidesMm(*motion, *before, rig), held = slidesMm(*motion, *after, rig);
        ASSERT_FALSE(slid.empty());
        std::printf("%s: %zu steps, slide median %.1f largest %.1f mm; held %.2f and %.2f mm\n", name, slid.size(),
                    double(slid[slid.size() / 2]), double(slid.back()), double(held[held.size() / 2]), double(held.back()));
        EXPECT_GT(slid.back(), 10.0f) << "there is something to correct";
        EXPECT_LT(held[held.size() / 2], 2.0f);
        float fastest = 0, fastestBefore = 0;
        for (const ClipChannel& channel : after->channels)
            for (size_t k = 1; k < after->timesS.size(); ++k) {
                const auto step = [&](const ClipData& clip) {
                    const auto& r = clip.channels[size_t(&channel - after->channels.data())].rotations;
                    return 2 * std::acos(std::min(1.0f, std::abs(glm::dot(r[k], r[k - 1])))) / (clip.timesS[k] - clip.timesS[k - 1]);
                };
                fastest = std::max(fastest, step(*after)), fastestBefore = std::max(fastestBefore, step(*before));
            }
        std::printf("  fastest joint %.1f, held %.1f rad/s\n", double(fastestBefore), double(fastest));
        EXPECT_LT(fastest, 1.35f * fastestBefore) << "rad/s: joints turn hardly faster than recorded";
    }
}

TEST(RetargetLooks, clipsOfOneKeyAndRigsWithoutLegsStay) {
    auto rig = personRig(0.8f);
    ClipData still;
    still.timesS = {0};
    still.rootTranslations = {Vec3f(0, 0.02f, 0)};
    plantFeet(rig, still);
    EXPECT_EQ(still.rootTranslations[0], Vec3f(0, 0.02f, 0));
    for (JointData& joint : rig) joint.humanoidBone.clear();
    ClipData clip;
    clip.timesS = {0, 1};
    plantFeet(rig, clip);
    EXPECT_TRUE(clip.channels.empty());
    for (const FootContact& contact : footContacts(rig, clip, "left")) EXPECT_FALSE(contact.ball || contact.ankle);
}

}  // namespace
}  // namespace dpl
