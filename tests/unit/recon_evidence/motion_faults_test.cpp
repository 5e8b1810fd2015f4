// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/evidence/motion_faults.h"

#include <gtest/gtest.h>

#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl::test {
namespace {

float turn(const Quatf& a, const Quatf& b) {
    return 2 * std::acos(std::min(1.0f, std::abs(glm::dot(a, b))));
}

TEST(MotionFaults, aSlowStepIsShortAndTowardsTheNextPose) {
    Pose from = Pose::rest(2), to = from;
    from.localRotations[1] = glm::angleAxis(0.1f, Vec3f(1, 0, 0));
    to.localRotations[1] = -glm::angleAxis(0.5f, Vec3f(1, 0, 0));  // the same turn with the other sign
    to.rootTranslation = {0.1f, 0, 0};
    const Pose step = slowStep(from, to);
    EXPECT_NEAR(turn(from.localRotations[1], step.localRotations[1]), 0.02f, 1e-4f);
    EXPECT_NEAR(turn(to.localRotations[1], step.localRotations[1]), 0.38f, 1e-3f);
    EXPECT_NEAR(step.rootTranslation.x, 0.005f, 1e-5f) << "0.02 of 0.4 rad is a twentieth of the way";
    to = from;
    to.rootTranslation = {0, 0.5f, 0};
    EXPECT_NEAR(slowStep(from, to).rootTranslation.y, 0.01f, 1e-6f);
    to.rootTranslation = {0, 0.004f, 0};
    EXPECT_FLOAT_EQ(slowStep(from, to).rootTranslation.y, 0.004f) << "no further than the next pose";
}

MotionFaults faultsOf(ToyReconstruction& toy, const AvatarData& avatar) {
    const FrameSet set = toy.table.frames(Split::Train, toy.metric.cameras, toy.truth);
    AvatarView view = must(AvatarView::open(bytesOf(avatar), 2));
    return must(motionFaults(avatar, view, set.frames, toy.jobs));
}

TEST(MotionFaults, lightThatChangesFastFlickers) {
    ToyReconstruction toy;
    toy.takePictures(toy.avatar);
    AvatarData nervous = toy.avatar;
    nervous.correctives = ballCorrectives(nervous.mesh, {0, 0, 0, 5}, {0, 0, 0, 5});
    nervous.correctives.mean[5] = std::sin(0.5f);  // so that its light is 1 in the first moving frame, far from where light is clamped
    const double calm = faultsOf(toy, toy.avatar).flickerLevels, fast = faultsOf(toy, nervous).flickerLevels;
    EXPECT_GT(calm, 0) << "there are moving frames";
    EXPECT_GT(fast, 1.2 * calm) << calm << " and " << fast;
}

TEST(MotionFaults, stillFramesAloneShowNone) {
    ToyReconstruction toy;
    toy.takePictures(toy.avatar);
    FrameSet set = toy.table.frames(Split::Train, toy.metric.cameras, toy.truth);
    std::erase_if(set.frames, [](const TrainFrame& frame) { return frame.kind == FrameKind::Dynamic; });
    ASSERT_GE(set.frames.size(), 2u);
    AvatarData nervous = toy.avatar;
    nervous.correctives = ballCorrectives(nervous.mesh, {0, 0, 0, 5}, {0, 0, 0, 5});
    AvatarView view = must(AvatarView::open(bytesOf(nervous), 2));
    EXPECT_EQ(must(motionFaults(nervous, view, set.frames, toy.jobs)).flickerLevels, 0);
    EXPECT_EQ(must(motionFaults(nervous, view, {}, toy.jobs)).flickerLevels, 0) << "no frame at all";
}

}  // namespace
}  // namespace dpl::test
