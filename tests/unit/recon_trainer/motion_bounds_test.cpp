// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/motion_bounds.h"

#include <gtest/gtest.h>

#include <random>

#include "sdk/avatar/pose_correctives.h"
#include "sdk/format/motion_modes.h"

namespace dpl::test {
namespace {

constexpr uint32_t kNodes = 12;

std::vector<JointData> legAndArm() {
    std::vector<JointData> joints(3);
    joints[1].humanoidBone = "leftUpperLeg", joints[2].humanoidBone = "leftUpperArm";
    joints[1].parent = joints[2].parent = 0;
    return joints;
}

/** A strip of vertices 1 cm apart, with nodes 3 cm apart: a body, and then a skirt that follows the leg. */
MeshData strip() {
    MeshData mesh;
    for (uint32_t v = 0; v < 3 * kNodes; ++v) {
        mesh.restPositions.emplace_back(0.01f * float(v), 0, 0);
        mesh.jointIndices.push_back({1, 0, 0, 0}), mesh.jointWeights.push_back({200, 55, 0, 0});
    }
    mesh.layers = {{.name = "body", .role = "body", .vertexCount = 18},
                   {.name = "bottom", .role = "garment", .firstVertex = 18, .vertexCount = 18}};
    return mesh;
}

PoseCorrectiveData stripCorrectives(uint32_t seed) {
    PoseCorrectiveData c;
    c.modeCount = 1, c.nodeCount = kNodes, c.joints = {1}, c.mean.assign(6, 0), c.modes.assign(6, 0.1f), c.reach = 1;
    for (uint32_t v = 0; v < 3 * kNodes; ++v) {
        const uint32_t half = v / 18 * 6, own = std::min(v / 3, half + 4);
        c.nodeIndices.push_back({uint16_t(own), uint16_t(own + 1), 0, 0}), c.nodeWeights.push_back({155, 100, 0, 0});
    }
    c.nodes.assign(kNodes, Vec4f(0.5f));
    MotionModeData m;
    m.groups = {{.columnCount = 1}, {.columnCount = 1}, {.columnCount = 1}};  // has moved, leg, arm
    m.joints = {1, 2}, m.still.assign(2, {0, 0, 0, 1}), m.rangeRad.assign(2, {0, 1}), m.holdsS = {0};
    m.modes = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    addMotionModes(c, std::move(m));
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    for (Vec4f& node : c.nodes) node = Vec4f(0.05f * Vec3f(normal(random), normal(random), normal(random)), normal(random));
    return c;
}

TEST(MotionBounds, onlyClothesThatFollowAGroupKeepItsOffsets) {
    PoseCorrectiveData c = stripCorrectives(1);
    const PoseCorrectiveData before = c;
    MotionBounds(legAndArm(), strip(), c).apply(c);
    for (uint32_t n = 0; n < kNodes; ++n)
        for (uint32_t i = 0; i < 4; ++i) {
            const Vec4f now = c.nodes[n * 4 + i], had = before.nodes[n * 4 + i];
            EXPECT_EQ(now.w, had.w) << "brightness stays";
            if (i == 0)
                EXPECT_EQ(now, had) << "a mode of the pose stays";
            else if (n < 6 || i == 3)
                EXPECT_EQ(Vec3f(now), Vec3f(0)) << "node " << n << ", column " << i;
            else
                EXPECT_NE(Vec3f(now), Vec3f(0)) << "node " << n << ", column " << i;
        }
}

TEST(MotionBounds, neighboursConvergeToABoundedStrainAndThenRest) {
    for (uint32_t seed = 1; seed < 20; ++seed) {
        PoseCorrectiveData c = stripCorrectives(seed);
        const MotionBounds bounds(legAndArm(), strip(), c);
        const auto strain = [&](uint32_t n, uint32_t column) {
            return glm::length(Vec3f(c.nodes[n * 4 + column]) - Vec3f(c.nodes[(n + 1) * 4 + column])) / 0.03f;
        };
        Vec3f sum(0);
        for (uint32_t n = 6; n < kNodes; ++n) sum += Vec3f(c.nodes[n * 4 + 1]);
        for (int sweep = 0; sweep < 200; ++sweep) bounds.apply(c);
        for (uint32_t n = 6; n + 1 < kNodes; ++n) {
            EXPECT_LT(strain(n, 1), 0.25f) << "has moved";
            EXPECT_LT(strain(n, 2), 0.1f) << "a component";
            sum -= Vec3f(c.nodes[n * 4 + 1]);
        }
        sum -= Vec3f(c.nodes[11 * 4 + 1]);
        EXPECT_LT(glm::length(sum), 1e-5f) << "the mean stays";
        const PoseCorrectiveData once = c;
        bounds.apply(c);
        for (size_t e = 0; e < c.nodes.size(); ++e)
            EXPECT_LT(glm::length(once.nodes[e] - c.nodes[e]), 1e-7f) << "nothing is beyond its bound";
    }
}

TEST(MotionBounds, anArmBeyondTrainingSilencesNoSkirt) {
    PoseCorrectiveData c = stripCorrectives(2);
    c.joints = {1, 2}, c.mean.assign(12, 0), c.modes.assign(12, 0), c.reachOffModes = 0.6f;
    std::fill_n(c.modes.begin(), 6, 0.1f);  // the film shows the leg alone
    c.motion.movedFromRad = 0.05f, c.motion.movedToRad = 0.15f;
    MotionBounds(legAndArm(), strip(), c).apply(c);
    Pose within = Pose::rest(3);
    within.localRotations[1] = glm::angleAxis(0.5f, Vec3f(1, 0, 0));
    Pose beyond = within;
    beyond.localRotations[2] = glm::angleAxis(2.8f, Vec3f(0, 0, 1));
    std::vector<float> k, far;
    correctiveCoefficients(c, within, k);
    correctiveCoefficients(c, beyond, far);
    EXPECT_LT(std::abs(far[0]), 0.3f * std::abs(k[0])) << "what follows the pose has faded";
    k[0] = far[0] = 0;  // what is left are motion modes
    std::vector<Vec4f> nodes, nodesFar;
    correctiveNodes(c, k, nodes);
    correctiveNodes(c, far, nodesFar);
    for (uint32_t n = 6; n < kNodes; ++n) {
        EXPECT_GT(glm::length(Vec3f(nodes[n])), 1e-3f) << "node " << n << " of the skirt";
        EXPECT_EQ(Vec3f(nodes[n]), Vec3f(nodesFar[n])) << "node " << n << " of the skirt";
    }
}

TEST(MotionBounds, heldPeaksStrainLessThanThePoseTheyAddTo) {
    PoseCorrectiveData c = stripCorrectives(3);
    MotionModeData m = c.motion;
    m.holdsS = {0, 6};
    m.modes = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};  // has moved, by the hold; the leg's angle; what is held of it
    c.motion = m;
    const MotionBounds bounds(legAndArm(), strip(), c);
    for (int sweep = 0; sweep < 200; ++sweep) bounds.apply(c);
    float angle = 0, peak = 0;
    for (uint32_t n = 6; n + 1 < kNodes; ++n) {
        const auto strain = [&](uint32_t column) {
            return glm::length(Vec3f(c.nodes[n * 4 + column]) - Vec3f(c.nodes[(n + 1) * 4 + column])) / 0.03f;
        };
        angle = std::max(angle, strain(2)), peak = std::max(peak, strain(3));
    }
    EXPECT_GT(peak, 0);
    EXPECT_LT(peak, 0.6f * angle);
}

}  // namespace
}  // namespace dpl::test
