// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "reconstruction/judging/report/score.h"
#include "reconstruction/run/stage_pose_fit.h"
#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl::test {
namespace {

constexpr size_t kStill = 5, kMoving = 7;  // held-out frames

class StagePoseFit : public testing::Test {
protected:
    Result<FoundPoses> fit() {
        dpl::Run run(toy_.chain, toy_.jobs, toy_.progress);
        toy_.giveTrained(run);
        DPL_TRY(const FoundPoses* found, run.get<FoundPoses>());
        return *found;
    }
    double psnrDb(size_t f, const Pose& pose) {
        AvatarView view = must(AvatarView::open(toy_.package.bytes, 2));
        const FramePicture picture = must(readFramePicture(toy_.table.scan.frames[f]));
        return scorePicture(must(view.draw(pose, toy_.metric.cameras[f])), picture.image, picture.mask).maskedPsnrDb;
    }

    ToyReconstruction toy_;
};

float angleBetween(const Quatf& a, const Quatf& b) {
    return 2 * std::acos(std::min(1.0f, std::abs(glm::dot(a, b))));
}

TEST_F(StagePoseFit, movesRootAndJointsOfHeldOutFramesAndLowersTheError) {
    // The registered pose of both frames is wrong by a turn of the root, a turn of the joint, and 2 cm.
    for (const size_t f : {kStill, kMoving}) {
        toy_.truth[f].localRotations[0] = glm::angleAxis(0.06f, Vec3f(0, 1, 0));
        toy_.truth[f].localRotations[1] = glm::angleAxis(0.08f, Vec3f(0, 0, 1)) * toy_.truth[f].localRotations[1];
        toy_.truth[f].rootTranslation = {0.015f, 0.012f, 0};
    }
    toy_.takePictures(toy_.avatar);
    const std::vector<uint8_t> avatarBefore = toy_.package.bytes;
    const auto found = fit();
    ASSERT_TRUE(found) << found.error().message;
    for (const size_t f : {kStill, kMoving}) {
        const FramePose& frame = found->poses.frames[f];
        ASSERT_TRUE(frame.fittedPose) << frame.name;
        EXPECT_GT(psnrDb(f, *frame.fittedPose), psnrDb(f, frame.pose) + 2) << frame.name;
        for (size_t j = 0; j < 2; ++j) {
            EXPECT_NE(frame.fittedPose->localRotations[j], frame.pose.localRotations[j]) << frame.name << ", joint " << j;
            EXPECT_LT(angleBetween(frame.fittedPose->localRotations[j], toy_.truth[f].localRotations[j]),
                      angleBetween(frame.pose.localRotations[j], toy_.truth[f].localRotations[j]))
                << frame.name << ", joint " << j;
        }
        EXPECT_LT(glm::length(frame.fittedPose->rootTranslation - toy_.truth[f].rootTranslation),
                  0.7f * glm::length(frame.pose.rootTranslation - toy_.truth[f].rootTranslation))
            << frame.name;
    }
    EXPECT_EQ(toy_.package.bytes, avatarBefore);
    for (const auto& entry : std::filesystem::directory_iterator(found->file.parent_path()))
        EXPECT_TRUE(entry.path().filename() == "poses.json" || entry.path().filename() == "manifest.json") << entry.path();
}

TEST_F(StagePoseFit, keepsTheTrainedPosesOfTrainingFrames) {
    toy_.takePictures(toy_.avatar);
    toy_.training.result.poses[1].rootTranslation = {0.01f, 0.02f, 0.03f};
    toy_.table.usable[2] = false;  // then training has only four poses
    toy_.training.result.poses.erase(toy_.training.result.poses.begin() + 2);
    toy_.registered.poses[2].rootTranslation = {0.5f, 0, 0};
    const auto found = fit();
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_EQ(found->poses.frames.size(), ToyReconstruction::kFrames);
    for (size_t f = 0; f < ToyReconstruction::kTrained; ++f) {
        EXPECT_EQ(found->poses.frames[f].split, Split::Train);
        EXPECT_FALSE(found->poses.frames[f].fittedPose);
    }
    EXPECT_EQ(found->poses.frames[1].pose.rootTranslation, Vec3f(0.01f, 0.02f, 0.03f));
    EXPECT_EQ(found->poses.frames[2].pose.rootTranslation, Vec3f(0.5f, 0, 0)) << "not trained on: the registered pose";
    EXPECT_EQ(found->poses.frames[4].pose.localRotations[1], toy_.truth[4].localRotations[1]);
    EXPECT_EQ(found->poses.jointNames, (std::vector<std::string>{"root", "upper"}));
}

TEST_F(StagePoseFit, registersHeldOutFramesByTheirTrainedNeighbours) {
    toy_.takePictures(toy_.avatar);
    for (Pose& pose : toy_.training.result.poses) pose.rootTranslation += Vec3f(0, 0.03f, 0);  // training moved every pose
    std::filesystem::remove(toy_.table.scan.frames[kStill].imagePath);
    const auto found = fit();
    ASSERT_TRUE(found) << found.error().message;
    const FramePose &still = found->poses.frames[kStill], &moving = found->poses.frames[kMoving];
    EXPECT_NEAR(still.pose.rootTranslation.y, 0.03f, 1e-6) << "as its trained neighbours";
    EXPECT_FALSE(still.fittedPose) << "a frame without a picture keeps its registered pose";
    EXPECT_NEAR(moving.pose.rootTranslation.y, 0.03f, 1e-6) << "its own pose, moved as training moved its neighbours";
    EXPECT_LT(angleBetween(moving.pose.localRotations[1], toy_.truth[kMoving].localRotations[1]), 1e-3f);
}

}  // namespace
}  // namespace dpl::test
