// SPDX-License-Identifier: Apache-2.0
// Learned offsets tear no garment, whatever pose and state they are drawn in.
#include "sdk/avatar/cloth_strain.h"

#include <gtest/gtest.h>

#include <limits>

#include "sdk/avatar/posed_mesh.h"
#include "tests/unit/avatar/clothed_legs.h"

namespace dpl {
namespace {

using test::clothedLegs;
using test::stride;

std::vector<Vec4f> nodesIn(const AvatarData& a, const Pose& pose) {
    std::vector<float> k;
    std::vector<Vec4f> nodes;
    correctiveCoefficients(a.correctives, pose, k);
    correctiveNodes(a.correctives, k, nodes);
    return nodes;
}

struct Eased {
    std::vector<Vec4f> nodes;
    float mostM = 0;
    Eased(const AvatarData& a, std::vector<Vec4f> from, float drawn = 0) : nodes(std::move(from)) {
        std::vector<Vec3f> scratch;
        mostM = ClothStrain(a.mesh, a.correctives).ease(nodes, drawn, scratch);
    }
};

/** The largest difference of the offsets of an edge's ends over its length, of one layer. */
double largestStrain(const AvatarData& a, const LayerData& layer, const std::vector<Vec4f>& nodes) {
    Jobs jobs(1);
    std::vector<Vec3f> moved;
    std::vector<float> light;
    spreadCorrectives(a.correctives, nodes, a.mesh.restPositions, jobs, moved, light);
    double most = 0;
    for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t)
        for (int c = 0; c < 3; ++c) {
            const uint32_t p = a.mesh.triangles[t][c], q = a.mesh.triangles[t][(c + 1) % 3];
            const Vec3f edge = a.mesh.restPositions[p] - a.mesh.restPositions[q];
            most = std::max(most, double(glm::length(moved[p] - moved[q] - edge) / glm::length(edge)));
        }
    return most;
}

/** A strip of garment in edges of 1 cm, whose weights go over from the first node to the second along its middle edge. */
AvatarData strip(uint32_t edges = 10) {
    AvatarData a;
    for (uint32_t i = 0; i <= edges; ++i)
        for (const float z : {0.0f, 0.01f}) {
            a.mesh.restPositions.emplace_back(0.01f * float(i), 0, z);
            a.correctives.nodeIndices.emplace_back(0, 1, 0, 0);
            a.correctives.nodeWeights.push_back(i < edges / 2 ? glm::u8vec4(255, 0, 0, 0) : glm::u8vec4(0, 255, 0, 0));
        }
    for (uint32_t i = 0; i < edges; ++i) {
        a.mesh.triangles.push_back({2 * i, 2 * i + 1, 2 * i + 2});
        a.mesh.triangles.push_back({2 * i + 1, 2 * i + 3, 2 * i + 2});
    }
    a.mesh.layers = {{"strip", "garment", 0, uint32_t(a.mesh.restPositions.size()), 0, uint32_t(a.mesh.triangles.size())}};
    a.correctives.modeCount = 1, a.correctives.nodeCount = 2;
    a.correctives.nodes = {Vec4f(0), Vec4f(0.05f, 0, 0, 0.5f)};
    return a;
}

TEST(ClothStrain, anEdgeWhoseWeightsGoOverTearsNoFurtherThanTheLimit) {
    const AvatarData a = strip();
    const Eased eased(a, {Vec4f(0, 0, 0, 0), Vec4f(0.05f, 0, 0, 0.5f)});
    EXPECT_NEAR(largestStrain(a, a.mesh.layers[0], {Vec4f(0), Vec4f(0.05f, 0, 0, 0)}), 5, 1e-4) << "the strip was whole";
    EXPECT_NEAR(largestStrain(a, a.mesh.layers[0], eased.nodes), kMostStrain, 1e-4);
    EXPECT_NEAR(eased.nodes[0].x + eased.nodes[1].x, 0.05f, 1e-7f) << "both go half of the way";
    EXPECT_NEAR(eased.mostM, eased.nodes[0].x, 1e-7f);
    EXPECT_EQ(eased.nodes[1].w, 0.5f) << "brightness is no offset";
}

TEST(ClothStrain, offsetsWithinTheLimitKeepEveryBit) {
    const AvatarData a = strip();
    const std::vector<Vec4f> nodes{Vec4f(0.01f, 0, 0, 0), Vec4f(0.01f + 0.99f * kMostStrain * 0.01f, 0, 0, 0)};
    const Eased eased(a, nodes);
    EXPECT_TRUE(eased.nodes == nodes);
    EXPECT_EQ(eased.mostM, 0);
}

TEST(ClothStrain, theNearerAPoseIsToThoseOfTheFilmTheMoreItMayStrain) {
    const AvatarData a = strip();
    const std::vector<Vec4f> nodes{Vec4f(0), Vec4f(0.05f, 0, 0, 0)};
    for (const float filmed : {0.2f, 0.5f, 0.8f})
        EXPECT_NEAR(largestStrain(a, a.mesh.layers[0], Eased(a, nodes, filmed * kFilmedShare).nodes), kMostStrain / (1 - filmed), 1e-4);
    for (const float drawn : {kFilmedShare, 0.7f, 1.0f}) {
        const Eased filmed(a, nodes, drawn);
        EXPECT_TRUE(filmed.nodes == nodes);
        EXPECT_EQ(filmed.mostM, 0);
    }
}

TEST(ClothStrain, aSkirtOfManyNodesIsEasedInAnyPose) {
    AvatarData a = clothedLegs();
    for (Vec4f& offset : a.correctives.nodes) offset *= 4;
    double before = 0, after = 0;
    for (const float angle : {-0.8f, -0.3f, 0.2f, 0.6f, 1.1f}) {
        const std::vector<Vec4f> nodes = nodesIn(a, stride(angle, -0.7f * angle));
        const Eased eased(a, nodes);
        before = std::max(before, largestStrain(a, a.mesh.layers[1], nodes));
        after = std::max(after, largestStrain(a, a.mesh.layers[1], eased.nodes));
        float most = 0;
        for (size_t n = 0; n < nodes.size(); ++n) most = std::max(most, glm::length(Vec3f(eased.nodes[n]) - Vec3f(nodes[n])));
        EXPECT_NEAR(eased.mostM, most, 1e-6f);
    }
    EXPECT_GT(before, 4 * kMostStrain);
    EXPECT_LT(after, 1.5 * kMostStrain) << "offsets of neighbours that have nothing in common; two sweeps do not quite end that";
}

TEST(ClothStrain, bodiesAndNodesThatLearnedNothingAreLeftAlone) {
    AvatarData body = strip(), same = strip(), none = strip();
    body.mesh.layers[0].role = "body";
    same.correctives.nodes[0] = same.correctives.nodes[1];
    none.correctives = {};
    for (const AvatarData* a : {&body, &same, &none}) EXPECT_TRUE(ClothStrain(a->mesh, a->correctives).empty());
    EXPECT_FALSE(ClothStrain(strip().mesh, strip().correctives).empty());
}

TEST(ClothStrain, edgesWithoutLengthAndNodesThatAreNoNumbersAreSurvived) {
    AvatarData a = strip();
    a.mesh.restPositions[10] = a.mesh.restPositions[8];
    a.mesh.triangles[3] = {4, 4, 4};
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Eased eased(a, {Vec4f(nan, 0, 0, 0), Vec4f(0.05f, 0, 0, 0)});
    EXPECT_EQ(eased.nodes[1], Vec4f(0.05f, 0, 0, 0)) << "what is no number spreads nowhere";
}

}  // namespace
}  // namespace dpl
