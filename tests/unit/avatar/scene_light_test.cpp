// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/scene_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sdk/avatar/posed_mesh.h"
#include "tests/unit/format/sample_avatars.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl::test {
namespace {

class SceneLight : public testing::Test {
protected:
    SceneLight() { avatar_.light.irradiance = {-0.4f, 0.3f, -0.2f, 0.1f, 0.05f, -0.15f, 0.1f, 0.2f}; }

    std::vector<float> factorsIn(const Pose& pose) {
        std::vector<Mat3x4f> joints;
        jointTransforms(avatar_.joints, pose, joints);
        std::vector<float> factors;
        lightFactors(avatar_.mesh, avatar_.light, restVertexNormals(avatar_.mesh), joints, jobs_, factors);
        return factors;
    }
    Pose turnedBy(const Quatf& turn) const {
        Pose pose = Pose::rest(avatar_.joints.size());
        pose.localRotations[0] = turn;
        return pose;
    }

    Jobs jobs_{2};
    AvatarData avatar_ = layeredAvatar(3, 0);
};

TEST_F(SceneLight, isOneAtRestWhereverTheSubjectStands) {
    Pose pose = Pose::rest(avatar_.joints.size());
    pose.rootTranslation = {3, -1, 2};
    for (const float f : factorsIn(pose)) EXPECT_NEAR(f, 1, 1e-5);
}

TEST_F(SceneLight, staysInTheWorldWhileTheSubjectTurns) {
    const Quatf turn = glm::angleAxis(2.0f, glm::normalize(Vec3f(0.3f, 1, -0.2f)));
    const std::vector<Vec3f> normals = restVertexNormals(avatar_.mesh);
    const std::vector<float> factors = factorsIn(turnedBy(turn));
    float least = 1, most = 1;
    for (size_t v = 0; v < factors.size(); ++v) {
        const float want = irradianceOn(avatar_.light, turn * normals[v]) / irradianceOn(avatar_.light, normals[v]);
        EXPECT_NEAR(factors[v], want, 1e-4) << v;
        least = std::min(least, factors[v]), most = std::max(most, factors[v]);
    }
    EXPECT_LT(least, 0.8f);
    EXPECT_GT(most, 1.3f * least);
    for (const float f : factorsIn(turnedBy(glm::angleAxis(6.2831853f, Vec3f(0, 1, 0))))) EXPECT_NEAR(f, 1, 1e-5) << "a whole turn";
}

TEST_F(SceneLight, meetsTheCorrectivesWithinTheBoundsOfBrightness) {
    avatar_.correctives = randomCorrectives(avatar_, 5, {.modes = 4, .nodes = 20, .light = 1.0f, .reach = 3});
    for (float& c : avatar_.light.irradiance) c *= 3;
    const Pose pose = turnedBy(glm::angleAxis(2.5f, Vec3f(0, 1, 0)));
    PosedMesh both, corrected;
    both.pose({avatar_.joints, avatar_.mesh, avatar_.correctives, {}, &avatar_.light}, pose, jobs_);
    corrected.pose({avatar_.joints, avatar_.mesh, avatar_.correctives, {}}, pose, jobs_);
    const std::vector<float> factors = factorsIn(pose);
    uint32_t clamped = 0, free = 0;
    for (size_t v = 0; v < factors.size(); ++v) {
        const float product = corrected.light()[v] * factors[v];
        EXPECT_NEAR(both.light()[v], std::clamp(product, kMinLight, kMaxLight), 1e-6f) << v;
        EXPECT_EQ(both.sceneLight()[v], factors[v]) << v;
        ++(product < kMinLight || product > kMaxLight ? clamped : free);
    }
    EXPECT_GT(clamped, 0u);
    EXPECT_GT(free, 0u);
    both.pose({avatar_.joints, avatar_.mesh, {}, {}}, pose, jobs_);
    EXPECT_TRUE(both.light().empty() && both.sceneLight().empty()) << "nothing stays of an avatar with light";
}

TEST_F(SceneLight, isFiniteWithoutNormals) {
    avatar_.mesh.restPositions.assign(avatar_.mesh.restPositions.size(), Vec3f(0.1f, 1, 0));
    for (const float f : factorsIn(turnedBy(glm::angleAxis(1.0f, Vec3f(1, 0, 0))))) EXPECT_TRUE(f > 0.05f && f < 20) << f;
}

TEST(RestNormals, areTheSameOnBothSidesOfASeam) {
    MeshData mesh;  // two triangles at an angle, whose common edge has two vertices a side
    mesh.restPositions = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, -1}};
    mesh.triangles = {{0, 2, 1}, {3, 4, 5}};
    const std::vector<Vec3f> normals = restVertexNormals(mesh);
    EXPECT_EQ(normals[0], normals[3]);
    EXPECT_EQ(normals[1], normals[4]);
    EXPECT_NEAR(glm::length(normals[0]), 1, 1e-6);
    EXPECT_LT(glm::dot(normals[0], normals[2]), 0.99f) << "the edge is not flat";
}

}  // namespace
}  // namespace dpl::test
