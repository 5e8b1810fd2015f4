// SPDX-License-Identifier: Apache-2.0
// The subject in a skirt: one tube about both legs, which spans them, swings farther than shorts and stays outside raised thighs.
#include <gtest/gtest.h>

#include "reconstruction/subject/sample/skeleton.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "tests/unit/recon_sample/subjects.h"

namespace dpl {
namespace {

const LayerData& skirt() {
    return skirted().mesh.layers.back();
}

TEST(Skirt, changesNothingButTheBottomAndTheShirtOverIt) {
    const Subject &s = skirted(), &shorts = subject();
    ASSERT_EQ(s.mesh.layers.size(), shorts.mesh.layers.size());
    for (size_t i : {0, 1, 2}) {  // body, hair, shoes
        const LayerData& layer = s.mesh.layers[i];
        ASSERT_EQ(layer.vertexCount, shorts.mesh.layers[i].vertexCount) << layer.name;
        for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v)
            ASSERT_EQ(s.mesh.restPositions[v], shorts.mesh.restPositions[v]) << layer.name;
    }
    EXPECT_EQ(s.look.skin, shorts.look.skin);
    EXPECT_EQ(s.mesh.layers.back().name, "bottom");
    EXPECT_NE(s.name, shorts.name);
}

TEST(Skirt, isATubeWithAWaistAndAHem) {
    const MeshData& mesh = skirted().mesh;
    const auto loops = openings(mesh, skirt());
    float low = 10, high = 0;
    for (const std::vector<uint32_t>& loop : loops)
        for (const uint32_t v : loop) low = std::min(low, mesh.restPositions[v].y), high = std::max(high, mesh.restPositions[v].y);
    EXPECT_EQ(loops.size(), 2u);
    EXPECT_GT(high - low, 0.4f);
}

TEST(Skirt, weightsChangeSlowlyBetweenTheLegs) {
    const MeshData& mesh = skirted().mesh;
    const auto weightOf = [&](uint32_t v, uint32_t joint) {
        for (int k = 0; k < 4; ++k)
            if (mesh.jointIndices[v][k] == joint) return float(mesh.jointWeights[v][k]) / 255;
        return 0.0f;
    };
    float most = 0, left = 0, right = 0;
    for (uint32_t t = skirt().firstTriangle; t < skirt().firstTriangle + skirt().triangleCount; ++t)
        for (int c = 0; c < 3; ++c) {
            const uint32_t a = mesh.triangles[t][c], b = mesh.triangles[t][(c + 1) % 3];
            if (mesh.restPositions[a].y > 0.75f) continue;  // above, cloth lies on the body
            for (uint32_t joint : {uint32_t(kLeftHip), uint32_t(kRightHip)})
                most = std::max(most, std::abs(weightOf(a, joint) - weightOf(b, joint)));
            left = std::max(left, weightOf(a, kLeftHip)), right = std::max(right, weightOf(a, kRightHip));
        }
    EXPECT_LT(most, 0.2f);  // smoothed like other cloth it is 0.3
    EXPECT_GT(left, 0.5f);
    EXPECT_GT(right, 0.5f);
}

TEST(Skirt, swingsFartherThanShortsAndStaysOutsideTheLegs) {
    const Subject& s = skirted();
    const SampleMotion motion = SampleMotion::dynamicSequence(6, 18.75);
    SwingSimulation swing(s, motion);
    double most = 0;
    for (double t = 0.5; t < 18.5; t += 0.25) {
        const std::vector<Vec3d>& lag = swing.at(t);
        for (uint32_t d = 0; d < s.drivers.size(); ++d)
            if (s.drivers[d].maxLagM > 0.1) most = std::max(most, glm::length(lag[d]));
    }
    EXPECT_GT(most, 0.05);
    EXPECT_LT(most, 0.12);

    SwingSimulation again(s, motion);
    for (double t : {12.6, 14.2}) {  // a knee is up
        const std::vector<Vec3d> lag = again.at(t);
        const auto at = poseSubject(s, motion.pose(t), &lag), skinnedOnly = poseSubject(s, motion.pose(t), nullptr);
        const auto depthShare = [&](const std::vector<Vec3d>& posed) {
            const LayerData& body = s.mesh.layers[0];
            const ClosestSurface skin(std::vector<Vec3f>(posed.begin(), posed.begin() + body.vertexCount),
                                      std::span(s.mesh.triangles).first(body.triangleCount));
            size_t inside = 0;
            for (uint32_t v = skirt().firstVertex; v < skirt().firstVertex + skirt().vertexCount; ++v)
                inside += skin.signedDistance(Vec3f(posed[v]), 0.1f) < 0;
            return double(inside) / skirt().vertexCount;
        };
        EXPECT_LT(depthShare(at), 0.002) << t;
        EXPECT_GT(depthShare(skinnedOnly), depthShare(at)) << t;
    }
}

}  // namespace
}  // namespace dpl
