// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "reconstruction/subject/shape/edge_uses.h"
#include "reconstruction/subject/shape/spread_place.h"
#include "reconstruction/subject/shape/vertex_sets.h"

namespace dpl {
namespace {

// A square of two triangles, and a triangle beside it.
const std::vector<Triangle> kTriangles = {{2, 1, 0}, {2, 3, 1}, {6, 5, 4}};

TEST(VertexSets, piecesHaveTheNumberOfTheirLowestVertex) {
    VertexSets pieces(8, kTriangles);
    for (uint32_t v = 0; v < 8; ++v) EXPECT_EQ(pieces.find(v), v < 4 ? 0u : v < 7 ? 4u : 7u) << v;
    pieces.join(5, 3);
    EXPECT_EQ(pieces.find(6), 0u);
    EXPECT_EQ(pieces.find(7), 7u) << "no triangle uses it";
}

TEST(EdgeUses, bordersAreUsedOnce) {
    const auto uses = edgeUses(kTriangles);
    ASSERT_EQ(uses.size(), 8u);
    for (const auto& [edge, count] : uses) {
        EXPECT_LT(edge.first, edge.second);
        EXPECT_EQ(count, edge == edgeOf(2, 1) ? 2 : 1) << edge.first << " " << edge.second;
    }
}

TEST(SpreadPlace, placesLieInTheTriangleAndCoverIt) {
    int quarters[4] = {};  // the four triangles between the middles of the edges
    for (uint32_t k = 0; k < 400; ++k) {
        const Vec2d p = spreadPlace(0.5, k);
        ASSERT_GE(std::min(p.x, p.y), 0);
        ASSERT_LE(p.x + p.y, 1);
        ++quarters[p.x > 0.5 ? 0 : p.y > 0.5 ? 1 : p.x + p.y < 0.5 ? 2 : 3];
    }
    for (const int count : quarters) EXPECT_NEAR(count, 100, 4);
}

}  // namespace
}  // namespace dpl
