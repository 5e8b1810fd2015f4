// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/poses_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>

#include "sdk/core/files.h"

namespace {

using namespace dpl;

class PosesFileTest : public testing::Test {
protected:
    std::filesystem::path path_ = std::filesystem::temp_directory_path() / ("doppel_poses_" + std::to_string(::getpid()) + ".json");
    void TearDown() override { std::filesystem::remove(path_); }

    PosesFile sample() {
        PosesFile poses;
        poses.jointNames = {"hips", "spine"};
        FramePose frame{"full_003", FrameKind::StaticCloseup, Split::Validation, Pose::rest(2), Pose::rest(2)};
        frame.fittedPose->localRotations[1] = Quatf(0.6f, 0, 0.8f, 0);
        frame.pose.rootTranslation = {1, 2, 3};
        poses.frames = {frame};
        return poses;
    }
};

TEST_F(PosesFileTest, readsBackWhatWasWritten) {
    ASSERT_TRUE(writeFileAtomically(path_, posesToJson(sample())));
    auto back = readPosesFile(path_);
    ASSERT_TRUE(back) << back.error().message;
    ASSERT_EQ(back->frames.size(), 1u);
    EXPECT_EQ(back->frames[0].name, "full_003");
    EXPECT_EQ(back->frames[0].kind, FrameKind::StaticCloseup);
    EXPECT_EQ(back->frames[0].split, Split::Validation);
    EXPECT_EQ(back->frames[0].pose.rootTranslation, Vec3f(1, 2, 3));
    ASSERT_TRUE(back->frames[0].fittedPose);
    EXPECT_EQ(&back->frames[0].bestPose(), &*back->frames[0].fittedPose);
    EXPECT_FLOAT_EQ(back->frames[0].fittedPose->localRotations[1].y, 0.8f);
}

TEST_F(PosesFileTest, namesScanAvatarAndSkeleton) {
    PosesFile poses = sample();
    poses.scanHash = "5ca1", poses.avatarHash = "xxh3:a7a7";
    poses.restPositions = {{0, 1, 0}, {0, 1.2f, 0.01f}};
    ASSERT_TRUE(writeFileAtomically(path_, posesToJson(poses)));
    const auto back = readPosesFile(path_);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->scanHash, "5ca1");
    EXPECT_EQ(back->avatarHash, "xxh3:a7a7");
    EXPECT_EQ(back->restPositions, poses.restPositions);

    std::vector<JointData> joints(2);
    joints[0].name = "hips", joints[0].restPosition = {0, 1, 0};
    joints[1].name = "spine", joints[1].restPosition = {0, 1.2f, 0.0105f};
    EXPECT_TRUE(checkSkeleton(*back, path_, joints, "packed.glb")) << "half a millimetre of rounding";
    joints[1].restPosition.y = 1.23f;
    const Status other = checkSkeleton(*back, path_, joints, "bob.glb");
    ASSERT_FALSE(other);
    for (const char* part : {"bob.glb", path_.c_str(), "spine", "30 mm"})
        EXPECT_NE(other.error().message.find(part), std::string::npos) << other.error().message;
    joints[1].restPosition.y = std::nanf("");
    EXPECT_FALSE(checkSkeleton(*back, path_, joints, "bob.glb"));
    joints.pop_back();
    EXPECT_FALSE(checkSkeleton(*back, path_, joints, "bob.glb"));
}

TEST_F(PosesFileTest, everyTruncationIsAnErrorThatNamesTheFile) {
    const std::string good = posesToJson(sample());
    for (size_t length = 0; length < good.size(); length += 7) {
        ASSERT_TRUE(writeFileAtomically(path_, good.substr(0, length)));
        auto back = readPosesFile(path_);
        ASSERT_FALSE(back) << length;
        EXPECT_NE(back.error().message.find(path_.string()), std::string::npos);
    }
}

TEST_F(PosesFileTest, aRotationTooFewNamesTheFrame) {
    std::string text = posesToJson(sample());
    text.replace(text.find("\"hips\","), 7, "");
    ASSERT_TRUE(writeFileAtomically(path_, text));
    auto back = readPosesFile(path_);
    ASSERT_FALSE(back);
    EXPECT_NE(back.error().message.find("full_003"), std::string::npos);
}

TEST_F(PosesFileTest, anUnknownKindOrSplitNamesTheFrame) {
    for (const auto& [name, other] : {std::pair("static_closeup", "near"), std::pair("validation", "val")}) {
        std::string text = posesToJson(sample());
        text.replace(text.find(name), std::string_view(name).size(), other);
        ASSERT_TRUE(writeFileAtomically(path_, text));
        const auto back = readPosesFile(path_);
        ASSERT_FALSE(back) << other;
        EXPECT_NE(back.error().message.find("full_003"), std::string::npos) << back.error().message;
        EXPECT_NE(back.error().message.find(name), std::string::npos) << back.error().message;
    }
}

TEST_F(PosesFileTest, theScaleOfTheScansWorldIsKept) {
    PosesFile poses = sample();
    ASSERT_TRUE(writeFileAtomically(path_, posesToJson(poses)));
    EXPECT_EQ(readPosesFile(path_)->metresPerUnit, 0) << "not stated";
    poses.metresPerUnit = 0.37;
    std::string text = posesToJson(poses);
    ASSERT_TRUE(writeFileAtomically(path_, text));
    EXPECT_EQ(readPosesFile(path_)->metresPerUnit, 0.37);
    text.replace(text.find("0.37"), 4, "-1.0");
    ASSERT_TRUE(writeFileAtomically(path_, text));
    auto back = readPosesFile(path_);
    ASSERT_FALSE(back);
    EXPECT_NE(back.error().message.find("metres_per_unit"), std::string::npos);
}

}  // namespace
