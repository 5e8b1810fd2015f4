// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/still_vertices.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl::test {
namespace {

TEST(StillVertices, correctivesMoveSplatsAndLeaveTheBodyBelowClothes) {
    Jobs jobs(2);
    PoseCorrectiveData truth = toyCorrectives(ballMesh());
    truth.nodes = {Vec4f(0, 0.02f, 0.01f, 0), Vec4f(0.015f, 0, 0, 0)};
    CoOptimiseInput input = toyScene(jobs, 8, 0, 0, 72, truth);
    input.mesh = dressedBall(500);
    input.correctives = toyCorrectives(input.mesh);
    const MeshData mesh = input.mesh;
    const auto joints = input.joints;
    const Pose bent = input.frames[1].pose;
    CoOptimiseSettings settings = toySettings(60);
    settings.rateNodeOffset = 2e-3f, settings.learnGeometry = false;
    auto trainer = CoOptimiser::create(std::move(input), settings, jobs);
    ASSERT_TRUE(trainer) << trainer.error().message;
    ASSERT_TRUE((*trainer)->run());
    const CoOptimiseResult r = (*trainer)->result();
    ASSERT_TRUE(checkCorrectives(r.correctives, joints.size(), mesh.restPositions.size()));
    std::vector<uint8_t> carries(mesh.restPositions.size(), 0);
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) carries[mesh.triangles[t][k]] |= r.splats.triangleStart[t + 1] > r.splats.triangleStart[t];
    const auto bind = restTriangles(mesh);
    PosedMesh posed;
    posed.pose({joints, mesh, r.correctives, bind}, bent, jobs);
    size_t bare = 0;
    float most = 0;
    for (size_t v = 0; v < mesh.layers[0].vertexCount; ++v) {
        const float move = glm::length(posed.rest()[v] - mesh.restPositions[v]);
        if (carries[v]) {
            most = std::max(most, move);
        } else {
            ++bare;
            ASSERT_EQ(move, 0) << "vertex " << v;
        }
    }
    EXPECT_GT(bare, 50u);
    EXPECT_LT(bare, mesh.layers[0].vertexCount) << "the body near the hem carries splats";
    EXPECT_GT(most, 0.001f) << "the rest follows the pose";
}

TEST(StillVertices, nothingIsAddedToEmptyCorrectives) {
    PoseCorrectiveData none;
    holdBareVertices(ballMesh(), TrainableSplats{}, none);
    EXPECT_TRUE(none.empty());
    EXPECT_EQ(none.nodeCount, 0u);
}

}  // namespace
}  // namespace dpl::test
