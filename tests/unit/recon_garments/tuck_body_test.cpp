// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/tuck_body.h"

#include <gtest/gtest.h>

#include "reconstruction/subject/garments/cloth_faults.h"
#include "reconstruction/subject/garments/priors.h"
#include "tests/unit/ball_mesh.h"

namespace dpl::test {
namespace {

/** A garment that ends at the equator, so deep in the body of 20 cm. */
AvatarData sunkenGarment(float depthM) {
    AvatarData avatar;
    avatar.joints.resize(2);
    avatar.joints[1].parent = 0;
    MeshData& mesh = avatar.mesh;
    mesh = dressedBall(532, 0.2f - depthM);
    LayerData& garment = mesh.layers[1];
    garment.vertexCount = 1 + 10 * 28;  // those above the equator, ring by ring
    mesh.restPositions.resize(garment.firstVertex + garment.vertexCount);
    mesh.jointIndices.resize(mesh.restPositions.size()), mesh.jointWeights.resize(mesh.restPositions.size());
    return avatar;
}

/** 1 for the lower part of the body, five rings of triangles below the garment. */
std::vector<uint8_t> lowerPartSeen(const MeshData& mesh) {
    std::vector<uint8_t> seen(mesh.triangles.size(), 0);
    for (uint32_t t = 0; t < mesh.layers[0].triangleCount; ++t) {
        const Triangle& corner = mesh.triangles[t];
        seen[t] = mesh.restPositions[corner.x].y + mesh.restPositions[corner.y].y + mesh.restPositions[corner.z].y < -0.42f;
    }
    return seen;
}

double inside(const AvatarData& avatar, const Pose& pose) {
    Jobs jobs(2);
    return garmentPenetration(avatar, std::span(&pose, 1), jobs);
}

float farthestMove(const MeshData& before, const MeshData& after) {
    float farthest = 0;
    for (size_t v = 0; v < before.restPositions.size(); ++v)
        farthest = std::max(farthest, glm::length(after.restPositions[v] - before.restPositions[v]));
    return farthest;
}

TEST(TuckBody, takesUnseenSkinInBelowAGarment) {
    Jobs jobs(2);
    const AvatarData before = sunkenGarment(0.004f);
    const Pose rest = Pose::rest(2);
    ASSERT_GT(inside(before, rest), 0.9);
    AvatarData after = before;
    const std::vector<uint8_t> seen = lowerPartSeen(before.mesh);
    EXPECT_GT(tuckBody(after, seen, std::span(&rest, 1), jobs), 100u);
    EXPECT_EQ(inside(after, rest), 0);
    EXPECT_LT(farthestMove(before.mesh, after.mesh), 0.008f) << "as deep as needed, with 2 mm of clearance";
    for (uint32_t t = 0; t < before.mesh.layers[0].triangleCount; ++t)
        for (int c = 0; seen[t] && c < 3; ++c) {
            const uint32_t v = before.mesh.triangles[t][c];
            ASSERT_EQ(after.mesh.restPositions[v], before.mesh.restPositions[v]) << "seen skin";
        }
    for (size_t v = before.mesh.layers[1].firstVertex; v < before.mesh.restPositions.size(); ++v)
        ASSERT_EQ(after.mesh.restPositions[v], before.mesh.restPositions[v]) << "the garment";
}

TEST(TuckBody, looksAtEveryPose) {
    // Both follow joint 0, but for the body's upper half, which joint 1 moves up into the garment.
    Jobs jobs(2);
    AvatarData before = sunkenGarment(-0.004f);
    const LayerData& garment = before.mesh.layers[1];
    std::fill_n(before.mesh.jointWeights.begin() + garment.firstVertex, garment.vertexCount, glm::u8vec4(255, 0, 0, 0));
    before.joints[1].restPosition = {0, 0, -0.5f};
    Pose raised = Pose::rest(2);
    raised.localRotations[1] = glm::angleAxis(-0.016f, Vec3f(1, 0, 0));  // 8 mm up at half a metre
    ASSERT_EQ(inside(before, Pose::rest(2)), 0);
    const double found = inside(before, raised);
    ASSERT_GT(found, 0.1);
    AvatarData after = before;
    const std::vector<Pose> poses = {Pose::rest(2), raised};
    EXPECT_GT(tuckBody(after, lowerPartSeen(before.mesh), poses, jobs), 20u);
    EXPECT_LT(inside(after, raised), 0.1 * found);
}

TEST(TuckBody, goesNoDeeperThanACentimetre) {
    Jobs jobs(2);
    const AvatarData before = sunkenGarment(0.03f);
    const Pose rest = Pose::rest(2);
    AvatarData after = before;
    tuckBody(after, lowerPartSeen(before.mesh), std::span(&rest, 1), jobs);
    EXPECT_NEAR(farthestMove(before.mesh, after.mesh), priors::kTuckM, 1e-5f);
}

TEST(TuckBody, doesNotTurnThinPartsInsideOut) {
    Jobs jobs(2);
    AvatarData before = sunkenGarment(0.03f);
    for (Vec3f& p : before.mesh.restPositions) p *= Vec3f(1, 1, 0.04f);  // a disc, 16 mm thick at its middle
    const Pose rest = Pose::rest(2);
    AvatarData after = before;
    tuckBody(after, lowerPartSeen(before.mesh), std::span(&rest, 1), jobs);
    for (uint32_t v = 0; v < before.mesh.layers[0].vertexCount; ++v) {
        const float z0 = before.mesh.restPositions[v].z, z1 = after.mesh.restPositions[v].z;
        if (std::abs(z0) > 0.001f) {
            ASSERT_GT(z0 * z1, 0) << "vertex " << v << " moved through the disc, from " << z0 << " to " << z1;
        }
    }
    EXPECT_GT(farthestMove(before.mesh, after.mesh), 0.001f);
}

TEST(TuckBody, leavesAnAvatarOfOneLayer) {
    Jobs jobs(2);
    AvatarData avatar = sunkenGarment(0.004f);
    const std::vector<Vec3f> before = avatar.mesh.restPositions;
    const Pose rest = Pose::rest(2);
    const std::vector<uint8_t> seen(avatar.mesh.triangles.size(), 0);
    EXPECT_EQ(tuckBody(avatar, seen, {}, jobs), 0u) << "no pose";
    EXPECT_EQ(avatar.mesh.restPositions, before) << "no pose";
    avatar.mesh.layers.resize(1);
    EXPECT_EQ(tuckBody(avatar, seen, std::span(&rest, 1), jobs), 0u) << "no garment";
    EXPECT_EQ(avatar.mesh.restPositions, before) << "no garment";
}

}  // namespace
}  // namespace dpl::test
