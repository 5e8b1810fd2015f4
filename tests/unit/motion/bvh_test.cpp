// SPDX-License-Identifier: Apache-2.0
// BVH texts: unusual but valid ones, damaged ones and hostile ones.
#include <gtest/gtest.h>

#include "sdk/motion/motion.h"

namespace dpl {
namespace {

const std::string kGood =
    "HIERARCHY\r\nROOT hip\r\n{\r\n  OFFSET 0 100 0\r\n  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\r\n"
    "  JOINT upper leg {\r\n OFFSET 0 -50 0\n CHANNELS 3 yROTATION Xrotation zrotation\n End Site\n { OFFSET 0 -100 0\n }\n }\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.5\n\n1 103 2 90 0 0 +0 90 0\n1 103 2 0 0 0\n 0 0 1e-3\n\n";

TEST(Bvh, readsAnyChannelOrderEndSitesAndOddSpacing) {
    const auto motion = readBvh(kGood, "good.bvh");
    ASSERT_TRUE(motion) << motion.error().message;
    ASSERT_EQ(motion->joints.size(), 3u);
    EXPECT_EQ(motion->joints[1].name, "upper leg");
    EXPECT_EQ(motion->joints[2].name, "upper leg end");
    EXPECT_EQ(motion->joints[2].parent, 1);
    EXPECT_FLOAT_EQ(motion->metresPerUnit, 0.01f);
    EXPECT_FLOAT_EQ(motion->joints[1].restPosition.y, 0.5f);
    EXPECT_FLOAT_EQ(motion->timesS[1], 0.5f);
    std::vector<Quatf> rotations;
    std::vector<Vec3f> positions;
    motionAt(*motion, 0, rotations, positions);
    EXPECT_LT(glm::length(positions[0] - Vec3f(0.01f, 1.03f, 0.02f)), 1e-6f)
        << "the first position of the root is nearer to its OFFSET than to 0, so it replaces OFFSET";
    // A quarter turn about z takes the thigh (0,−1,0) to (1,0,0). The knee adds a quarter turn about x in the thigh's frame.
    EXPECT_LT(glm::length(positions[1] - positions[0] - Vec3f(0.5f, 0, 0)), 1e-6f);
    EXPECT_LT(glm::length(positions[2] - positions[1] - Vec3f(0, 0, -1)), 1e-6f);
}

TEST(Bvh, everyTruncationIsAnErrorOrItsWholeFramesWithANote) {
    const auto whole = readBvh(kGood, "good.bvh");
    ASSERT_TRUE(whole);
    EXPECT_TRUE(whole->notes.empty());
    for (size_t size = 0; size < kGood.size(); ++size) {
        const auto motion = readBvh(std::string_view(kGood).substr(0, size), "cut.bvh");
        if (motion && motion->keyCount() == 2) {  // only trailing blanks were cut, or last digits of the last number
            EXPECT_GE(size, kGood.find("1e-3"));
        } else if (motion) {
            EXPECT_EQ(motion->keyCount(), 1u);
            EXPECT_GT(size, kGood.find("+0 90 0")) << "the line behind the first frame tells that its last number is whole";
            ASSERT_EQ(motion->notes.size(), 1u);
            EXPECT_EQ(motion->notes[0], "'Frames:' promises 2 frames, there are 1: the file may be cut off");
            EXPECT_EQ(motion->rotations[1], whole->rotations[1]);
        } else {
            EXPECT_NE(motion.error().message.find("cut.bvh"), std::string::npos);
        }
    }
}

TEST(Bvh, rejectsWithALineAndAReason) {
    const auto with = [](const std::string& from, const std::string& to) {
        std::string text = kGood;
        const size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        text.replace(at, from.size(), to);
        const auto motion = readBvh(text, "bad.bvh");
        EXPECT_FALSE(motion) << from << " -> " << to;
        return motion ? std::string() : motion.error().message;
    };
    EXPECT_NE(with("+0 90", "x 90").find("(frame 1, joint 'upper leg')"), std::string::npos);
    EXPECT_NE(with("HIERARCHY", "Kinematics").find("begins with 'Kinematics' instead of HIERARCHY"), std::string::npos);
    with("Frames: 2", "Frames: 4000000000");
    with("Frames: 2", "Frames: -2");
    with("Frames: 2", "Frames: 1.5");
    with("Frame Time: 0.5", "Frame Time: 0");
    with("Frame Time: 0.5", "Frame Time: nan");
    with("CHANNELS 3", "CHANNELS 7");
    with("yROTATION", "Wrotation");
    with("yROTATION", "zrotation");
    with("OFFSET 0 -50 0", "OFFSET 0 -50");
    with("OFFSET 0 -50 0", "OFFSET 0 1e300 0");
    with("HIERARCHY", "HIERARCHIE");
    with("MOTION", "}");
    with("90 0 0", "90 0 x");
    EXPECT_NE(with("MOTION", "ROOT again { OFFSET 0 0 0 }\nMOTION").find("second ROOT"), std::string::npos);
}

/** kGood with `from` replaced. */
Result<Motion> changed(const std::string& from, const std::string& to) {
    std::string text = kGood;
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return readBvh(text.replace(at, from.size(), to), "changed.bvh");
}

TEST(Bvh, labelsStandWithOrWithoutSpaces) {
    const auto whole = readBvh(kGood, "good.bvh");
    for (const char* labels :
         {"Frames:2\nFrame Time:0.5", "Frames :2\nFrame Time : 0.5", "FRAMES: 2\nFrameTime: 0.5", "frames\t2\nframe\ttime 0.5"}) {
        const auto motion = changed("Frames: 2\nFrame Time: 0.5", labels);
        ASSERT_TRUE(motion) << labels << ": " << motion.error().message;
        EXPECT_EQ(motion->rotations, whole->rotations) << labels;
        EXPECT_EQ(motion->timesS, whole->timesS) << labels;
        EXPECT_TRUE(motion->notes.empty()) << labels;
    }
}

TEST(Bvh, framesThatDisagreeWithTheirNumberAreCounted) {
    const auto whole = readBvh(kGood, "good.bvh");
    const auto more = changed("Frames: 2", "Frames: 1");
    ASSERT_TRUE(more) << more.error().message;
    EXPECT_EQ(more->keyCount(), 1u);
    EXPECT_EQ(more->rotations[1], whole->rotations[1]);
    EXPECT_EQ(more->notes, std::vector<std::string>{"'Frames:' promises 1 frames, 1 more stand below them and were left out"});
    for (const char* promise : {"3", "1000000"}) {
        const auto fewer = changed("Frames: 2", std::string("Frames: ") + promise);
        ASSERT_TRUE(fewer) << fewer.error().message;
        EXPECT_EQ(fewer->rotations, whole->rotations);
        EXPECT_EQ(fewer->notes,
                  std::vector<std::string>{std::string("'Frames:' promises ") + promise + " frames, there are 2: the file may be cut off"});
    }
}

TEST(Bvh, framesWithNumbersThatAreNotFiniteAreLeftOutAndCounted) {
    const auto whole = readBvh(kGood, "good.bvh");
    for (const char* none : {"nan", "-nan", "NaN", "inf", "-inf", "Infinity", "-nan(ind)", "1.#QNAN", "-1.#IND", "1e300"}) {
        const auto second = changed("1 103 2 0 0 0\n 0", std::string("1 103 2 0 0 0\n ") + none);
        ASSERT_TRUE(second) << none << ": " << second.error().message;
        EXPECT_EQ(second->keyCount(), 1u) << none;
        EXPECT_EQ(second->rotations[1], whole->rotations[1]);
        EXPECT_EQ(second->notes, std::vector<std::string>{"1 of 2 frames have numbers that are not finite and were left out"});
        const auto first = changed("1 103 2 90", std::string("1 ") + none + " 2 90");
        ASSERT_TRUE(first) << none;
        EXPECT_EQ(first->keyCount(), 1u);
        EXPECT_EQ(first->timesS.front(), 0.0f) << "times begin at 0 whatever was left out";
        EXPECT_EQ(first->rotations[1], whole->rotations[whole->joints.size() + 1]);
    }
    std::string all = kGood;
    for (size_t at; (at = all.find("103")) != std::string::npos;) all.replace(at, 3, "nan");
    const auto none = readBvh(all, "all.bvh");
    ASSERT_FALSE(none);
    EXPECT_NE(none.error().message.find("no frame has only finite numbers"), std::string::npos);
}

TEST(Bvh, deepAndWideTreesAreRefusedWithoutHarm) {
    std::string deep = "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\n";
    for (int i = 0; i < 100000; ++i) deep += "JOINT j\n{\nOFFSET 0 0 0\n";
    EXPECT_FALSE(readBvh(deep, "deep.bvh"));
    std::string wide = "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\n";
    for (int i = 0; i < 5000; ++i) wide += "JOINT j\n{\nOFFSET 0 0 0\n}\n";
    EXPECT_FALSE(readBvh(wide, "wide.bvh"));
    EXPECT_FALSE(readBvh(
        "HIERARCHY ROOT a { OFFSET 0 0 0 CHANNELS 3 Xrotation Yrotation Zrotation CHANNELS 3 Xrotation Yrotation Zrotation } MOTION",
        "twice.bvh"));
    EXPECT_FALSE(readBvh(std::string_view("HIERARCHY\0\0\0", 12), "zeros.bvh"));
    EXPECT_FALSE(readBvh("HIERARCHY ROOT a { End Site { End Site { OFFSET 0 0 0 } } }", "ends.bvh"));
}

}  // namespace
}  // namespace dpl
