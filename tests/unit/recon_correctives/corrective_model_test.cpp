// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/correctives/corrective_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace dpl::test {
namespace {

/** Two walls of 0.5 × 1 m, 1 cm apart and not joined: near in space, far along the surface. */
MeshData twoWalls() {
    MeshData m;
    constexpr uint32_t kColumns = 26, kRows = 51;
    for (uint32_t wall = 0; wall < 2; ++wall)
        for (uint32_t r = 0; r < kRows; ++r)
            for (uint32_t c = 0; c < kColumns; ++c) m.restPositions.push_back({0.02f * float(c), 0.02f * float(r), 0.01f * float(wall)});
    for (uint32_t wall = 0; wall < 2; ++wall)
        for (uint32_t r = 0; r + 1 < kRows; ++r)
            for (uint32_t c = 0; c + 1 < kColumns; ++c) {
                const uint32_t a = (wall * kRows + r) * kColumns + c, b = a + 1, d = a + kColumns, e = d + 1;
                m.triangles.push_back({a, b, d});
                m.triangles.push_back({b, e, d});
            }
    return m;
}

std::vector<JointData> joints() {
    std::vector<JointData> j(4);
    j[0].humanoidBone = "hips", j[1].humanoidBone = "leftUpperArm", j[2].humanoidBone = "leftLowerArm",
    j[3].humanoidBone = "leftIndexProximal";
    for (int i = 1; i < 4; ++i) j[size_t(i)].parent = i - 1;
    return j;
}

/** Swings the arm and, less, the elbow. Hips and finger move most, but the model must ignore them. */
std::vector<Pose> swinging(uint32_t count) {
    std::vector<Pose> poses;
    for (uint32_t i = 0; i < count; ++i) {
        Pose p = Pose::rest(4);
        p.localRotations[0] = glm::angleAxis(2.0f * std::sin(5.0f * float(i)), Vec3f(0, 1, 0));
        p.localRotations[1] = glm::angleAxis(0.8f * std::sin(0.7f * float(i)), Vec3f(1, 0, 0));
        p.localRotations[2] = glm::angleAxis(0.3f * std::cos(1.9f * float(i)), Vec3f(0, 0, 1));
        p.localRotations[3] = glm::angleAxis(1.5f * std::cos(3.1f * float(i)), Vec3f(1, 0, 0));
        poses.push_back(p);
    }
    return poses;
}

TEST(CorrectiveModel, followsTheBodyAndIgnoresItsHeadingAndFingers) {
    const auto model = correctiveModel(joints(), twoWalls(), swinging(40));
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(model->joints, (std::vector<uint32_t>{1, 2}));
    EXPECT_GE(model->modeCount, 2u);
    EXPECT_LE(model->modeCount, 4u) << "two swings have few modes";
    EXPECT_TRUE(checkCorrectives(*model, 4, twoWalls().restPositions.size()));
}

TEST(CorrectiveModel, coefficientsAreCentredWithUnitVariance) {
    const auto poses = swinging(40);
    const auto model = correctiveModel(joints(), twoWalls(), poses);
    ASSERT_TRUE(model);
    std::vector<double> mean(model->modeCount, 0.0), square(model->modeCount, 0.0);
    std::vector<float> k;
    PoseCorrectiveData free = *model;
    free.reach = free.reachOffModes = 1e6f;
    int shortened = 0;
    for (const Pose& p : poses) {
        shortened += correctiveCoefficients(free, p, k).length > model->reach;
        for (size_t i = 0; i < k.size(); ++i) mean[i] += k[i] / 40.0, square[i] += k[i] * k[i] / 40.0;
    }
    for (size_t i = 0; i < mean.size(); ++i) {
        EXPECT_NEAR(mean[i], 0, 1e-5) << i;
        EXPECT_NEAR(square[i], 1, 1e-3) << i;
    }
    EXPECT_GT(shortened, 3) << "far poses are shortened";
    EXPECT_LT(shortened, 12) << "and near ones are not";
}

TEST(CorrectiveModel, fadesForPosesOfAnotherMotion) {
    const auto model = correctiveModel(joints(), twoWalls(), swinging(40));
    ASSERT_TRUE(model);
    std::vector<float> k;
    int faded = 0;
    for (const Pose& p : swinging(40)) faded += correctiveCoefficients(*model, p, k).offModes > model->reachOffModes;
    EXPECT_LE(faded, 2) << "its own poses act in full";
    Pose strange = Pose::rest(4);
    strange.localRotations[1] = glm::angleAxis(0.8f, Vec3f(0, 0, 1));  // in training the arm swings only about x
    EXPECT_GT(correctiveCoefficients(*model, strange, k).offModes, 5 * model->reachOffModes);
    float squares = 0;
    for (const float x : k) squares += x * x;
    EXPECT_LT(std::sqrt(squares), 0.2f * model->reach);
}

TEST(CorrectiveModel, nodesCoverTheSurfaceAndDoNotJumpGaps) {
    const MeshData mesh = twoWalls();
    const auto model = correctiveModel(joints(), mesh, swinging(40), {.nodeSpacingM = 0.1});
    ASSERT_TRUE(model);
    EXPECT_GT(model->nodeCount, 60u);
    EXPECT_LT(model->nodeCount, 400u);
    const size_t half = mesh.restPositions.size() / 2;
    std::set<uint16_t> nodesOf[2];
    for (size_t v = 0; v < mesh.restPositions.size(); ++v)
        for (int i = 0; i < 4; ++i)
            if (model->nodeWeights[v][i] > 0) nodesOf[v >= half].insert(model->nodeIndices[v][i]);
    for (const uint16_t n : nodesOf[0]) EXPECT_FALSE(nodesOf[1].contains(n)) << "node " << n << " moves both walls";
    EXPECT_EQ(nodesOf[0].size() + nodesOf[1].size(), model->nodeCount) << "every node moves something";
}

TEST(CorrectiveModel, isEmptyForTooFewOrEqualPoses) {
    const auto few = correctiveModel(joints(), twoWalls(), swinging(5));
    ASSERT_TRUE(few);
    EXPECT_TRUE(few->empty());
    const auto held = correctiveModel(joints(), twoWalls(), std::vector<Pose>(40, Pose::rest(4)));
    ASSERT_TRUE(held);
    EXPECT_TRUE(held->empty());
}

TEST(CorrectiveModel, refusesAPoseOfAnotherRig) {
    auto poses = swinging(20);
    poses[7].localRotations.pop_back();
    const auto model = correctiveModel(joints(), twoWalls(), poses);
    ASSERT_FALSE(model);
    EXPECT_EQ(model.error().code, Code::InvalidArgument);
}

}  // namespace
}  // namespace dpl::test
