// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "sdk/avatar/rig.h"
#include "tests/unit/avatar/rigs.h"

namespace dpl {
namespace {

using test::jointOf;
using test::personRig;

MeshData triangleAt(const Vec3f& a, const Vec3f& b, const Vec3f& c, uint16_t joint) {
    MeshData mesh;
    mesh.restPositions = {a, b, c};
    mesh.jointIndices.assign(3, glm::u16vec4(joint, 0, 0, 0));
    mesh.jointWeights.assign(3, glm::u8vec4(255, 0, 0, 0));
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

TEST(Pose, restPosePassesAndLeavesEveryPointWhereItIs) {
    const auto joints = personRig(0.8f);
    const Pose rest = Pose::rest(joints.size());
    ASSERT_TRUE(checkPose(joints, rest));
    std::vector<Mat3x4f> g;
    jointTransforms(joints, rest, g);
    for (size_t j = 0; j < joints.size(); ++j)
        EXPECT_LT(glm::length(Mat3f(g[j]) * joints[j].restPosition + g[j][3] - joints[j].restPosition), 1e-6f);
}

TEST(Pose, nanIsRefusedByJointName) {
    const auto joints = personRig(0);
    Pose pose = Pose::rest(joints.size());
    pose.localRotations[jointOf(joints, "leftLowerArm")].y = std::numeric_limits<float>::quiet_NaN();
    const auto status = checkPose(joints, pose);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, Code::InvalidArgument);
    EXPECT_NE(status.error().message.find("left_elbow"), std::string::npos) << status.error().message;
}

TEST(Pose, zeroAndHugeRotationsAreRefusedByJointName) {
    const auto joints = personRig(0);
    for (const Quatf& bad : {Quatf(0, 0, 0, 0), Quatf(1e30f, 0, 0, 0), Quatf(1e-20f, 0, 0, 0)}) {
        Pose pose = Pose::rest(joints.size());
        pose.localRotations[jointOf(joints, "head")] = bad;
        const auto status = checkPose(joints, pose);
        ASSERT_FALSE(status);
        EXPECT_NE(status.error().message.find("'head'"), std::string::npos) << status.error().message;
    }
}

TEST(Pose, wrongCountAndBadRootAreRefused) {
    const auto joints = personRig(0);
    EXPECT_FALSE(checkPose(joints, Pose::rest(joints.size() - 1)));
    EXPECT_FALSE(checkPose(joints, Pose::rest(0)));
    Pose pose = Pose::rest(joints.size());
    pose.rootTranslation.z = std::numeric_limits<float>::infinity();
    EXPECT_FALSE(checkPose(joints, pose));
    pose.rootTranslation.z = 1e20f;
    EXPECT_FALSE(checkPose(joints, pose));
}

TEST(Rig, parentsMustComeFirst) {
    std::vector<JointData> joints = {{"a", -1, {}, {}}, {"b", 1, {}, {}}};
    const auto status = checkRig(joints);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find("'b'"), std::string::npos);
    joints[1].parent = 0;
    EXPECT_TRUE(checkRig(joints));
    joints[1].restPosition.x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(checkRig(joints));
}

TEST(Skin, elbowBentByNinetyDegreesPutsTheHandAboveIt) {
    const auto joints = personRig(0);
    const size_t elbow = jointOf(joints, "leftLowerArm"), hand = jointOf(joints, "leftHand");
    const Vec3f e = joints[elbow].restPosition, w = joints[hand].restPosition;
    const MeshData mesh = triangleAt(w, w + Vec3f(0.01f, 0, 0), w + Vec3f(0, 0.01f, 0), uint16_t(elbow));
    Pose pose = Pose::rest(joints.size());
    pose.localRotations[elbow] = 3.0f * glm::angleAxis(glm::half_pi<float>(), Vec3f(0, 0, 1));  // unnormalised on purpose
    pose.rootTranslation = {1, 2, 3};
    ASSERT_TRUE(checkPose(joints, pose));
    std::vector<Mat3x4f> g;
    jointTransforms(joints, pose, g);
    Jobs jobs(2);
    std::vector<Vec3f> posed;
    skin(mesh, g, jobs, posed);
    const Vec3f offset = w - e, expected = e + Vec3f(-offset.y, offset.x, offset.z) + Vec3f(1, 2, 3);
    EXPECT_LT(glm::length(posed[0] - expected), 2e-6f) << "rotation by 90° about z maps (x, y) to (−y, x); float rounding";
    EXPECT_LT(glm::length(posed[2] - posed[0] - Vec3f(-0.01f, 0, 0)), 2e-6f);
}

TEST(Skin, weightsBlendLinearly) {
    const std::vector<JointData> joints = {{"root", -1, {0, 0, 0}, {}}, {"tip", 0, {0, 1, 0}, {}}};
    MeshData mesh = triangleAt({1, 1, 0}, {2, 1, 0}, {1, 2, 0}, 0);
    mesh.jointIndices[0] = {0, 1, 0, 0};
    mesh.jointWeights[0] = {51, 204, 0, 0};  // 0.2 and 0.8
    Pose pose = Pose::rest(2);
    pose.localRotations[1] = glm::angleAxis(glm::pi<float>(), Vec3f(0, 0, 1));
    std::vector<Mat3x4f> g;
    jointTransforms(joints, pose, g);
    Jobs jobs(1);
    std::vector<Vec3f> posed;
    skin(mesh, g, jobs, posed);
    EXPECT_LT(glm::length(posed[0] - Vec3f(0.2f * 1 + 0.8f * -1, 1, 0)), 1e-6f);
}

TEST(Triangles, posedFrameTurnsWithTheBodyAndDegenerateOnesAreInvalid) {
    MeshData mesh = triangleAt({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0);
    mesh.triangles.push_back({0, 1, 1});
    const auto rest = restTriangles(mesh);
    EXPECT_TRUE(rest[0].valid);
    EXPECT_FALSE(rest[1].valid);
    const std::vector<Vec3f> posed = {{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}};  // a quarter turn about z
    Jobs jobs(1);
    std::vector<TriangleFrame<float>> frames;
    poseTriangles(mesh, {rest}, posed, jobs, frames);
    EXPECT_TRUE(frames[0].valid);
    EXPECT_FALSE(frames[1].valid);
    EXPECT_LT(glm::length(frames[0].worldFromRest * Vec3f(1, 0, 0) - Vec3f(0, 1, 0)), 1e-6f);
    EXPECT_LT(glm::length(frames[0].normal - Vec3f(0, 0, 1)), 1e-6f);
}

TEST(Skin, sameBytesOnAnyThreadCount) {
    const auto joints = personRig(0.8f);
    MeshData mesh;
    for (uint32_t v = 0; v < 10000; ++v) {
        mesh.restPositions.push_back(Vec3f(float(v % 97), float(v % 31), float(v % 7)) * 0.01f);
        mesh.jointIndices.push_back(glm::u16vec4(v % joints.size(), (v + 3) % joints.size(), 0, 0));
        mesh.jointWeights.push_back(glm::u8vec4(v % 256, 255 - v % 256, 0, 0));
    }
    Pose pose = Pose::rest(joints.size());
    for (size_t j = 0; j < joints.size(); ++j)
        pose.localRotations[j] = glm::angleAxis(0.1f * float(j), glm::normalize(Vec3f(1, float(j), 2)));
    std::vector<Mat3x4f> g;
    jointTransforms(joints, pose, g);
    std::vector<Vec3f> one, three;
    Jobs jobs1(1), jobs3(3);
    skin(mesh, g, jobs1, one);
    skin(mesh, g, jobs3, three);
    EXPECT_EQ(one, three);
}

}  // namespace
}  // namespace dpl
