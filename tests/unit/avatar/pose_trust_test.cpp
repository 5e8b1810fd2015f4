// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/pose_trust.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dpl {
namespace {

/** Correctives of three joints of which 1 and 2 count. In training joint 1 turned about z with a standard deviation of 0.2 rad, as features
 *  (0, s, 0, −s, 0, 0) tell; joint 2 did not turn. */
PoseCorrectiveData trained() {
    PoseCorrectiveData c;
    c.modeCount = 1, c.nodeCount = 1;
    c.joints = {1, 2};
    c.mean.assign(12, 0.0f);
    c.modes.assign(12, 0.0f);
    const float deviation = 0.2f * std::sqrt(2.0f);  // of the feature's length
    c.modes[1] = std::sqrt(0.5f) / deviation, c.modes[3] = -c.modes[1];
    c.reach = 2;
    c.reachOffModes = 0.1f;
    return c;
}

Pose bent(size_t joint, float angleRad) {
    Pose pose = Pose::rest(3);
    pose.localRotations[joint] = glm::angleAxis(angleRad, Vec3f(0, 0, 1));
    return pose;
}

TEST(PoseTrust, theMeanPoseIsTrustedWholly) {
    PoseTrust trust;
    poseTrust(trained(), Pose::rest(3), trust);
    EXPECT_EQ(trust.offsets, 1);
    EXPECT_EQ(trust.away, 0);
    EXPECT_EQ(trust.joints, (std::vector<float>{-1, 0, 0})) << "joint 0 does not count";
}

TEST(PoseTrust, aTrainedJointIsMeasuredInItsOwnDeviations) {
    PoseTrust trust;
    poseTrust(trained(), bent(1, 0.2f), trust);
    EXPECT_NEAR(trust.joints[1], 1, 0.02);
    EXPECT_NEAR(trust.away, 0.5, 0.01) << "one of two deviations of reach";
    EXPECT_EQ(trust.offsets, 1);
    poseTrust(trained(), bent(1, 0.6f), trust);
    EXPECT_NEAR(trust.joints[1], 3, 0.1);
    EXPECT_LT(trust.offsets, 0.8f);
}

TEST(PoseTrust, aJointThatTrainingNeverTurnedIsFarAtOnceAndOffsetsFade) {
    PoseTrust trust;
    poseTrust(trained(), bent(2, 0.5f), trust);
    EXPECT_GT(trust.joints[2], 10);
    EXPECT_EQ(trust.joints[1], 0);
    EXPECT_GT(trust.offModes, 5);
    EXPECT_NEAR(trust.offsets, 1 / trust.offModes, 1e-6);
    EXPECT_EQ(trust.away, 0) << "the modes do not see it";
}

TEST(PoseTrust, whatIsDrawnIsTheShareThatCoefficientsKeep) {
    PoseCorrectiveData open = trained();
    open.reach = 1e6f, open.reachOffModes = 1e6f;
    Pose pose = bent(1, 0.9f);
    pose.localRotations[2] = glm::angleAxis(0.2f, Vec3f(1, 0, 0));
    std::vector<float> faded, whole;
    correctiveCoefficients(trained(), pose, faded);
    correctiveCoefficients(open, pose, whole);
    PoseTrust trust;
    poseTrust(trained(), pose, trust);
    EXPECT_NEAR(trust.offsets, faded[0] / whole[0], 1e-5);
    EXPECT_LT(trust.offsets, 0.5f);
}

TEST(PoseTrust, holdingAPoseBringsFarJointsToTheLimitAndLeavesOthers) {
    Pose pose = bent(2, 0.9f);
    pose.localRotations[0] = pose.localRotations[1] = glm::angleAxis(0.3f, Vec3f(0, 0, 1));
    const Pose before = pose;
    holdPose(trained(), 3, pose);
    EXPECT_EQ(pose.localRotations[0], before.localRotations[0]) << "the file does not know joint 0";
    EXPECT_EQ(pose.localRotations[1], before.localRotations[1]) << "1.5 deviations";
    PoseTrust trust;
    poseTrust(trained(), pose, trust);
    EXPECT_NEAR(trust.joints[2], 3, 0.01);
    EXPECT_GT(pose.localRotations[2].z, 0.01f) << "turned the same way, by less";
    EXPECT_NEAR(pose.localRotations[2].x, 0, 1e-6);
    const Pose held = pose;
    holdPose(trained(), 3.1f, pose);
    EXPECT_EQ(pose.localRotations[2], held.localRotations[2]);
}

TEST(PoseTrust, aMeanThatIsNoRotationHoldsToTheNearestOne) {
    PoseCorrectiveData c = trained();
    c.mean[6] = -1, c.mean[10] = -1;  // joint 2: columns of length zero
    Pose pose = bent(2, 2.0f);
    holdPose(c, 0.01f, pose);
    EXPECT_NEAR(std::abs(pose.localRotations[2].w), 1, 1e-4);
}

}  // namespace
}  // namespace dpl
