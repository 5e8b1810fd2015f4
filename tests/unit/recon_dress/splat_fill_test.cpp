// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/dress/splat_fill.h"

#include <gtest/gtest.h>

#include "reconstruction/training/trainer/init.h"
#include "tests/unit/ball_mesh.h"

namespace dpl::test {
namespace {

/** The front of the ball, where splats hide little. */
bool isFaint(const MeshData& mesh, size_t triangle) {
    return mesh.restPositions[mesh.triangles[triangle].x].z > 0.12f;
}

/** A closed ball with a splat on each triangle, those of the upper half from both sides; none on `bare`. */
LayerPart ball(const char* role, size_t bare) {
    LayerPart part{"part", role, ballMesh(20, 28), {}, {}, {}};
    part.mesh.colours.assign(part.mesh.restPositions.size(), glm::u8vec4(128));
    SplatData& s = part.splats;
    s.triangleStart = {0};
    for (size_t t = 0; t < part.mesh.triangles.size(); ++t) {
        if (t != bare) {
            const bool upper = part.mesh.restPositions[part.mesh.triangles[t].x].y > 0;
            s.uv.push_back({0.3f, 0.3f}), s.phi.push_back(0), s.scaleM.push_back(Vec2f(0.01f));
            s.opacity.push_back(isFaint(part.mesh, t) ? 0.01f : 0.9f);
            s.flags.push_back(uint8_t(kSplatCloth | (upper ? 0 : kSplatSingleFace)));
            s.sh.insert(s.sh.end(), {0.1f, 0.1f, 0.1f});
        }
        s.triangleStart.push_back(s.count());
    }
    return part;
}

size_t bareTriangle() {
    const MeshData mesh = ballMesh(20, 28);
    for (size_t t = mesh.triangles.size(); t-- > 0;)
        if (mesh.restPositions[mesh.triangles[t].x].z > 0.18f) return t;
    return 0;
}

Marks everywhere(const LayerPart& part) {
    return Marks(part.mesh.triangles.size(), 1);
}

TEST(SplatFill, mendedTrianglesShowTheSidesThatTheyShowed) {
    const size_t bare = bareTriangle();
    LayerPart part = ball("garment", bare);
    const LayerPart before = part;
    ASSERT_GT(mendGarment(everywhere(part), part), 40u);
    size_t both = 0, single = 0;
    for (size_t t = 0; t < part.mesh.triangles.size(); ++t)
        for (uint32_t i = part.splats.triangleStart[t]; i < part.splats.triangleStart[t + 1]; ++i) {
            if (t == bare) continue;
            ASSERT_EQ(part.splats.flags[i], before.splats.flags[before.splats.triangleStart[t]]) << "triangle " << t;
            if (isFaint(part.mesh, t)) ++(part.splats.flags[i] & kSplatSingleFace ? single : both);
        }
    EXPECT_GT(both, 20u);
    EXPECT_GT(single, 20u);
    ASSERT_LT(part.splats.triangleStart[bare], part.splats.triangleStart[bare + 1]);
    EXPECT_EQ(part.splats.flags[part.splats.triangleStart[bare]], kSplatCloth | kSplatSingleFace) << "a closed surface";
}

TEST(SplatFill, mendedHairShowsBothSides) {
    const size_t bare = bareTriangle();
    LayerPart part = ball("hair", bare);
    for (uint8_t& flag : part.splats.flags) flag = 0;
    ASSERT_GT(mendGarment(everywhere(part), part), 40u);
    ASSERT_LT(part.splats.triangleStart[bare], part.splats.triangleStart[bare + 1]);
    for (uint32_t i = 0; i < part.splats.count(); ++i) ASSERT_EQ(part.splats.flags[i], 0) << "splat " << i;
}

TEST(SplatFill, whatIsNotUncoveredStaysFaint) {
    LayerPart part = ball("garment", bareTriangle());
    const LayerPart before = part;
    EXPECT_EQ(mendGarment(Marks(part.mesh.triangles.size(), 0), part), 0u);
    EXPECT_EQ(part.splats.opacity, before.splats.opacity);
    EXPECT_EQ(part.mesh.colours, before.mesh.colours);
}

TEST(SplatFill, verticesOfKeptTrianglesKeepTheirColour) {
    LayerPart part = ball("garment", bareTriangle());
    const size_t count = part.mesh.triangles.size();
    Marks fill(count, 0);
    for (size_t t = 0; t < count; ++t) fill[t] = isFaint(part.mesh, t);
    fillSplats(fill, Marks(count, 0), fill, std::vector<Vec3f>(count, Vec3f(1, 0, 0)), part);
    std::vector<uint8_t> kept(part.mesh.restPositions.size(), 0);
    for (size_t t = 0; t < count; ++t)
        for (int k = 0; k < 3 && !fill[t]; ++k) kept[part.mesh.triangles[t][k]] = 1;
    size_t coloured = 0;
    for (size_t v = 0; v < kept.size(); ++v) {
        EXPECT_EQ(part.mesh.colours[v], kept[v] ? glm::u8vec4(128) : glm::u8vec4(255, 0, 0, 255)) << v;
        coloured += !kept[v];
    }
    EXPECT_GT(coloured, 20u);
}

TEST(SplatFill, aWideGapBetweenTwoColoursIsOneGradient) {
    LayerPart part = ball("body", size_t(-1));
    const size_t count = part.mesh.triangles.size();
    float low = 1e9f, high = -1e9f;
    for (const Vec3f& p : part.mesh.restPositions) low = std::min(low, p.y), high = std::max(high, p.y);
    const auto heightOf = [&](size_t t) { return (part.mesh.restPositions[part.mesh.triangles[t].x].y - low) / (high - low); };
    Marks distrusted(count, 0);
    for (size_t t = 0; t < count; ++t) {
        distrusted[t] = heightOf(t) > 0.2f && heightOf(t) < 0.8f;
        for (int c = 0; c < 3; ++c) part.splats.sh[3 * t + size_t(c)] = heightOf(t) < 0.5f ? -1.0f : 1.0f;
    }
    const std::vector<Vec3f> around = coloursAround(part, distrusted, triangleNeighbours(part.mesh));
    float darkest = 1, brightest = 0;
    for (size_t t = 0; t < count; ++t)
        if (!distrusted[t]) darkest = std::min(darkest, around[t].x), brightest = std::max(brightest, around[t].x);
    ASSERT_GT(brightest - darkest, 0.4f);
    for (size_t t = 0; t < count; ++t) {
        if (!(heightOf(t) > 0.4f && heightOf(t) < 0.6f)) continue;
        // Without a seam: in the middle it is neither of the two colours.
        EXPECT_NEAR((around[t].x - darkest) / (brightest - darkest), 0.5f, 0.3f) << heightOf(t);
    }
}

}  // namespace
}  // namespace dpl::test
