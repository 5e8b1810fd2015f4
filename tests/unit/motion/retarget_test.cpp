// SPDX-License-Identifier: Apache-2.0
// Retargets recorded CMU clips onto other rigs.
#include <gtest/gtest.h>

#include "sdk/motion/retarget.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/motion/mocap.h"

namespace dpl {
namespace {

using test::jointOf;
using test::kClips;
using test::personRig;
using test::positionsAt;

const char* const kLimbs[][2] = {{"leftUpperArm", "leftLowerArm"},   {"leftLowerArm", "leftHand"},     {"rightUpperArm", "rightLowerArm"},
                                 {"rightLowerArm", "rightHand"},     {"leftUpperLeg", "leftLowerLeg"}, {"leftLowerLeg", "leftFoot"},
                                 {"rightUpperLeg", "rightLowerLeg"}, {"rightLowerLeg", "rightFoot"}};
Vec3f direction(const std::vector<JointData>& rig, const std::vector<Vec3f>& p, const char* from, const char* to) {
    return glm::normalize(p[jointOf(rig, to)] - p[jointOf(rig, from)]);
}

float degreesBetween(const Vec3f& a, const Vec3f& b) {
    return glm::degrees(std::acos(glm::clamp(glm::dot(a, b), -1.0f, 1.0f)));
}

/** The MakeHuman files are z-up and face −y. Retargeting turns (x, y, z) to (x, z, −y). */
Vec3f toYUp(const Motion& motion, const Vec3f& v) {
    return motion.name.starts_with("mh_") ? Vec3f(v.x, v.z, -v.y) : v;
}

TEST(Retarget, everyClipGivesItsLimbDirectionsToAnAPoseRig) {
    const auto rig = personRig(0.8f);
    for (const char* name : kClips) {
        SCOPED_TRACE(name);
        NEED_MOCAP(motion, name);
        RetargetOptions options;
        options.keepLeadIn = true;
        options.plantFeet = false;  // a planted leg leaves the recorded directions by what its foot would slide
        const auto clip = retarget(*motion, rig, options);
        ASSERT_TRUE(clip) << clip.error().message;
        ASSERT_TRUE(checkClip(*clip, rig)) << checkClip(*clip, rig).error().message;
        ASSERT_EQ(clip->timesS.size(), motion->keyCount());
        std::vector<JointData> source = motion->joints;
        assignHumanoidBones(source);
        std::vector<Quatf> rotations;
        std::vector<Vec3f> from;
        float worst = 0;
        for (size_t k = 0; k < motion->keyCount(); k += 7) {
            motionAt(*motion, k, rotations, from);
            const auto to = positionsAt(*clip, rig, double(clip->timesS[k]));
            for (const auto& limb : kLimbs)
                worst = std::max(
                    worst, degreesBetween(toYUp(*motion, direction(source, from, limb[0], limb[1])), direction(rig, to, limb[0], limb[1])));
        }
        EXPECT_LT(worst, 0.1f) << "degrees; the construction is exact, acos of floats near 1 resolves 0.03°";
    }
}

TEST(Retarget, tPoseFrameMakesATPoseOfAnAPoseRig) {
    const auto rig = personRig(0.8f);
    NEED_MOCAP(motion, "02_01");
    RetargetOptions options;
    options.keepLeadIn = true;
    options.plantFeet = false;  // the T-pose is one frame, no stance
    const auto clip = retarget(*motion, rig, options);
    ASSERT_TRUE(clip) << clip.error().message;
    const auto p = positionsAt(*clip, rig, 0);
    // The T-pose of the Daz skeleton bends elbows and wrists by up to 18° (OFFSET of lHand: 22.6 0.77 7.07).
    EXPECT_LT(degreesBetween(direction(rig, p, "leftUpperArm", "leftLowerArm"), {1, 0, 0}), 8.0f);
    EXPECT_LT(degreesBetween(direction(rig, p, "rightUpperArm", "rightLowerArm"), {-1, 0, 0}), 8.0f);
    EXPECT_LT(degreesBetween(direction(rig, p, "leftLowerArm", "leftHand"), {1, 0, 0}), 20.0f);
    EXPECT_GT(p[jointOf(rig, "head")].y, 1.4f);
    EXPECT_NEAR(p[jointOf(rig, "leftFoot")].y, rig[jointOf(rig, "leftFoot")].restPosition.y, 0.06f);
}

TEST(Retarget, theBlendFromTheTPoseIsDroppedUnlessKept) {
    const auto rig = personRig(0.8f);
    NEED_MOCAP(motion, "02_01");
    const auto clip = retarget(*motion, rig);
    ASSERT_TRUE(clip);
    EXPECT_EQ(clip->timesS.size(), motion->keyCount() - 5) << "steps of 26, 29, 27, 20 and 7 degrees; then 2";
    EXPECT_EQ(clip->timesS.front(), 0.0f);
    EXPECT_NEAR(clip->rootTranslations.front().x, 0, 1e-6);
    EXPECT_NEAR(clip->rootTranslations.front().z, 0, 1e-6);
}

TEST(Retarget, walkingSwingsTheHandsAndBendsTheKneesForward) {
    const auto rig = personRig(0.8f);
    for (const char* name : {"02_01", "07_01", "05_01"}) {
        SCOPED_TRACE(name);
        NEED_MOCAP(motion, name);
        const auto clip = retarget(*motion, rig);
        ASSERT_TRUE(clip) << clip.error().message;
        Vec3f start(0), end(0);
        float swingMin = 1e9f, swingMax = -1e9f, kneeMax = 0, kneeBackMax = 0, lowest = 1e9f, highest = 0;
        for (double t = 0; t < clipDurationS(*clip); t += 0.02) {
            const auto p = positionsAt(*clip, rig, t);
            for (const Vec3f& v : p) ASSERT_TRUE(std::isfinite(v.x + v.y + v.z));
            const Vec3f left = glm::normalize(p[jointOf(rig, "leftUpperLeg")] - p[jointOf(rig, "rightUpperLeg")]);
            const Vec3f forward = glm::normalize(glm::cross(left, Vec3f(0, 1, 0)));
            const float swing = glm::dot(p[jointOf(rig, "leftHand")] - p[jointOf(rig, "hips")], forward);
            swingMin = std::min(swingMin, swing), swingMax = std::max(swingMax, swing);
            for (const std::string side : {"left", "right"}) {
                const Vec3f hip = p[jointOf(rig, side + "UpperLeg")], knee = p[jointOf(rig, side + "LowerLeg")],
                            foot = p[jointOf(rig, side + "Foot")];
                const Vec3f bow = knee - 0.5f * (hip + foot);  // offset of the knee from the line between hip and ankle
                kneeMax = std::max(kneeMax, glm::dot(bow, forward));
                kneeBackMax = std::max(kneeBackMax, -glm::dot(bow, forward));
                lowest = std::min(lowest, foot.y);
            }
            highest = std::max(highest, p[jointOf(rig, "head")].y);
            if (t == 0) start = p[jointOf(rig, "hips")];
            end = p[jointOf(rig, "hips")];
        }
        EXPECT_GT(swingMax - swingMin, 0.15f) << "metres; a walking hand swings";
        EXPECT_GT(kneeMax, 0.08f);
        EXPECT_LT(kneeBackMax, 0.04f) << "a straight leg may lock a little";
        EXPECT_GT(lowest, 0.02f);
        EXPECT_LT(lowest, 0.15f) << "the feet touch the floor";
        EXPECT_GT(highest, 1.4f);
        EXPECT_GT(glm::length(end - start), 1.0f) << "and the person gets somewhere";
        EXPECT_LT(glm::length(end - start), 12.0f);
    }
}

TEST(Retarget, everyClipKeepsItsFeetOnTheFloor) {
    const auto rig = personRig(0.8f);
    for (const char* name : kClips) {
        SCOPED_TRACE(name);
        NEED_MOCAP(motion, name);
        const auto clip = retarget(*motion, rig);
        ASSERT_TRUE(clip);
        float lowest = 1e9f;
        for (double t = 0; t <= clipDurationS(*clip); t += 0.05) {
            const auto p = positionsAt(*clip, rig, t);
            for (const char* bone : {"leftFoot", "rightFoot", "leftToes", "rightToes"})
                lowest = std::min(lowest, p[jointOf(rig, bone)].y - rig[jointOf(rig, bone)].restPosition.y);
        }
        EXPECT_NEAR(lowest, 0, 0.05f);
    }
}

TEST(Retarget, unitsDoNotMatter) {
    const auto rig = personRig(0.8f);
    NEED_MOCAP(motion, "02_01");
    EXPECT_FLOAT_EQ(motion->metresPerUnit, 0.01f);
    Motion bigger = *motion;
    for (JointData& j : bigger.joints) j.restPosition *= 3.0f;
    for (auto& t : bigger.translations)
        for (Vec3f& v : t.offsets) v *= 3.0f;
    const auto a = retarget(*motion, rig), b = retarget(bigger, rig);
    ASSERT_TRUE(a && b);
    EXPECT_LT(glm::length(a->rootTranslations.back() - b->rootTranslations.back()), 1e-3f);
}

TEST(Retarget, metresAndDecimetresAreToldApart) {
    NEED_MOCAP(cmu, "scaled_131_01");
    EXPECT_FLOAT_EQ(cmu->metresPerUnit, 1.0f);
    NEED_MOCAP(makeHuman, "mh_walk1");
    EXPECT_FLOAT_EQ(makeHuman->metresPerUnit, 0.1f);
}

TEST(Retarget, aSkeletonWithoutAPersonListsItsJoints) {
    const auto motion = readBvh(
        "HIERARCHY\nROOT box\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nJOINT lid\n{\nOFFSET 0 1 0\n"
        "CHANNELS 0\n}\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n0 0 0\n",
        "box.bvh");
    ASSERT_TRUE(motion) << motion.error().message;
    const auto clip = retarget(*motion, personRig(0));
    ASSERT_FALSE(clip);
    EXPECT_EQ(clip.error().code, Code::Unsupported);
    EXPECT_NE(clip.error().message.find("box, lid"), std::string::npos) << clip.error().message;
}

TEST(Retarget, aMissingBoneFollowsItsAncestor) {
    NEED_MOCAP(motion, "02_01");
    auto rig = personRig(0.8f);
    Motion cut = *motion;
    assignHumanoidBones(cut.joints);
    for (JointData& j : cut.joints)
        if (j.humanoidBone == "leftHand") j.humanoidBone.clear();
    std::vector<std::string> notes;
    RetargetOptions options;
    options.notes = &notes;
    const auto clip = retarget(cut, rig, options);
    ASSERT_TRUE(clip);
    for (const ClipChannel& channel : clip->channels) EXPECT_NE(rig[channel.joint].humanoidBone, "leftHand");
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_NE(notes[0].find("does not drive leftHand,"), std::string::npos) << notes[0];
}

TEST(Retarget, aRigInTPoseAndOneInAPoseMoveAlike) {
    NEED_MOCAP(motion, "05_09");
    const auto a = personRig(0.8f), t = personRig(0.0f);
    RetargetOptions options;
    options.plantFeet = false;
    const auto clipA = retarget(*motion, a, options), clipT = retarget(*motion, t, options);
    ASSERT_TRUE(clipA && clipT);
    const auto pa = positionsAt(*clipA, a, 4.0), pt = positionsAt(*clipT, t, 4.0);
    for (const auto& limb : kLimbs)
        EXPECT_LT(degreesBetween(direction(a, pa, limb[0], limb[1]), direction(t, pt, limb[0], limb[1])), 0.1f) << limb[0];
    // Limb lengths and hips are the same, so the hands are in the same place up to the height at which the feet are grounded.
    EXPECT_LT(glm::length(pa[jointOf(a, "leftHand")] - pt[jointOf(t, "leftHand")]), 0.03f);
}

}  // namespace
}  // namespace dpl
