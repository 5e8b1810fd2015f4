// SPDX-License-Identifier: Apache-2.0
// The atlas of a mesh: every triangle has its own place, the right way round and with room around its chart.
#include "reconstruction/output/package/mesh_atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "reconstruction/output/package/atlas_charts.h"
#include "reconstruction/output/package/atlas_packing.h"

namespace dpl {
namespace {

struct Shape {
    std::vector<Vec3f> positions;
    std::vector<Triangle> triangles;
    std::vector<AtlasKind> kind;
};

/** A closed ball with bumps: it has normals of all directions, and folds. */
Shape bumpyBall(int rings = 40, int sides = 60) {
    Shape out;
    for (int r = 0; r <= rings; ++r)
        for (int s = 0; s < sides; ++s) {
            const double polar = M_PI * r / rings, azimuth = 2 * M_PI * s / sides;
            const double radius = 0.5 + 0.12 * std::sin(5 * azimuth) * std::sin(6 * polar);
            out.positions.push_back(Vec3f(float(radius * std::sin(polar) * std::sin(azimuth)), float(radius * std::cos(polar)),
                                          float(radius * std::sin(polar) * std::cos(azimuth))));
        }
    for (int r = 0; r < rings; ++r)
        for (int s = 0; s < sides; ++s) {
            const uint32_t a = uint32_t(r * sides + s), b = uint32_t(r * sides + (s + 1) % sides), down = uint32_t(sides);
            out.triangles.push_back({a, a + down, b}), out.triangles.push_back({b, a + down, b + down});
        }
    out.kind.resize(out.triangles.size());
    return out;
}

double doubleArea(const std::array<Vec2f, 3>& c) {
    const Vec2f a = c[1] - c[0], b = c[2] - c[0];
    return double(a.x) * b.y - double(a.y) * b.x;
}

/** The chart of each texel whose centre a triangle covers; −1: none, −2: two triangles. */
std::vector<int> chartsOfTexels(const MeshAtlas& atlas) {
    std::vector<int> out(size_t(atlas.sidePx) * atlas.sidePx, -1);
    for (size_t t = 0; t < atlas.corners.size(); ++t) {
        const auto& c = atlas.corners[t];
        const double doubled = doubleArea(c);
        if (doubled == 0) continue;
        const Vec2f low = glm::min(c[0], glm::min(c[1], c[2])), high = glm::max(c[0], glm::max(c[1], c[2]));
        for (int y = int(low.y); y <= int(high.y); ++y)
            for (int x = int(low.x); x <= int(high.x); ++x) {
                bool inside = true;
                for (int k = 0; k < 3; ++k) {
                    const Vec2d edge = Vec2d(c[(k + 1) % 3] - c[k]), to = Vec2d(x + 0.5, y + 0.5) - Vec2d(c[k]);
                    inside = inside && (edge.x * to.y - edge.y * to.x) * (doubled > 0 ? 1 : -1) > 1e-3 * glm::length(edge);
                }
                int& texel = out[size_t(y) * atlas.sidePx + x];
                if (inside) texel = texel == -1 ? int(atlas.chart[t]) : -2;
            }
    }
    return out;
}

TEST(MeshAtlas, everyTriangleLiesWithinThePictureTheRightWayRound) {
    const Shape ball = bumpyBall();
    const auto atlas = layOutAtlas(ball.positions, ball.triangles, ball.kind, 512);
    ASSERT_TRUE(atlas) << atlas.error().message;
    EXPECT_GT(atlas->chartCount, 5u) << "a ball has no chart of more than half of it";
    EXPECT_LT(atlas->chartCount, 120u);
    for (size_t t = 0; t < ball.triangles.size(); ++t) {
        const Triangle& c = ball.triangles[t];
        const double area =
            glm::length(glm::cross(ball.positions[c.y] - ball.positions[c.x], ball.positions[c.z] - ball.positions[c.x])) / 2;
        const double texels = doubleArea(atlas->corners[t]) / 2;
        for (const Vec2f& p : atlas->corners[t]) ASSERT_TRUE(p.x > 0 && p.x < 512 && p.y > 0 && p.y < 512);
        if (area < 1e-9) continue;
        // Rows go down, so what is anticlockwise from outside has a negative area. The plane is at most 72° away: cosine 0.31.
        const double flat = area / (double(atlas->texelM) * atlas->texelM);
        EXPECT_LT(texels, -0.3 * flat) << t;
        EXPECT_GT(texels, -1.001 * flat) << t;
    }
}

TEST(MeshAtlas, noTexelIsOfTwoTrianglesAndChartsKeepTheirDistance) {
    const Shape ball = bumpyBall();
    const auto atlas = layOutAtlas(ball.positions, ball.triangles, ball.kind, 512);
    ASSERT_TRUE(atlas) << atlas.error().message;
    ASSERT_GE(atlas->gutterPx, 4u);
    const std::vector<int> texels = chartsOfTexels(*atlas);
    const int side = 512, reach = 2 * int(atlas->gutterPx) - 1;
    size_t covered = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const int own = texels[size_t(y) * side + x];
            ASSERT_NE(own, -2) << "two triangles at " << x << " " << y;
            if (own < 0) continue;
            ++covered;
            for (int qy = std::max(0, y - reach); qy <= std::min(side - 1, y + reach); ++qy)
                for (int qx = std::max(0, x - reach); qx <= std::min(side - 1, x + reach); ++qx) {
                    const int other = texels[size_t(qy) * side + qx];
                    ASSERT_TRUE(other == own || other == -1) << x << " " << y << " and " << qx << " " << qy;
                }
        }
    EXPECT_GT(covered, size_t(side) * side * 2 / 5) << "the picture is not used";
}

TEST(MeshAtlas, kindsShareNoChartAndDenserOnesGetMoreTexels) {
    Shape ball = bumpyBall();
    for (size_t t = 0; t < ball.triangles.size(); ++t) ball.kind[t] = {0, ball.positions[ball.triangles[t].x].y > 0 ? 2.0f : 1.0f};
    const auto atlas = layOutAtlas(ball.positions, ball.triangles, ball.kind, 512);
    ASSERT_TRUE(atlas) << atlas.error().message;
    std::vector<float> density(atlas->chartCount, 0);
    double texels[2] = {}, area[2] = {};
    for (size_t t = 0; t < ball.triangles.size(); ++t) {
        float& of = density[atlas->chart[t]];
        EXPECT_TRUE(of == 0 || of == ball.kind[t].density);
        of = ball.kind[t].density;
        const Triangle& c = ball.triangles[t];
        texels[of > 1] -= doubleArea(atlas->corners[t]);
        area[of > 1] += glm::length(glm::cross(ball.positions[c.y] - ball.positions[c.x], ball.positions[c.z] - ball.positions[c.x]));
    }
    EXPECT_NEAR((texels[1] / area[1]) / (texels[0] / area[0]), 4, 0.4) << "the halves mirror each other but for the bumps";
}

TEST(MeshAtlas, aChartThatWouldCoverAPlaceTwiceIsCut) {
    // A ramp that winds up by two turns: nowhere steep, but the second turn lies over the first.
    Shape ramp;
    for (int s = 0; s <= 80; ++s)
        for (int side = 0; side < 2; ++side) {
            const double angle = 4 * M_PI * s / 80, radius = side ? 1 : 0.5;
            ramp.positions.push_back(Vec3f(float(radius * std::cos(angle)), float(0.005 * s), float(-radius * std::sin(angle))));
        }
    for (uint32_t s = 0; s < 80; ++s)
        ramp.triangles.push_back({2 * s, 2 * s + 1, 2 * s + 2}), ramp.triangles.push_back({2 * s + 2, 2 * s + 1, 2 * s + 3});
    ramp.kind.resize(ramp.triangles.size());
    const auto atlas = layOutAtlas(ramp.positions, ramp.triangles, ramp.kind, 512);
    ASSERT_TRUE(atlas) << atlas.error().message;
    EXPECT_GE(atlas->chartCount, 2u);
    for (const int texel : chartsOfTexels(*atlas)) ASSERT_NE(texel, -2);
}

TEST(MeshAtlas, seamsSplitVerticesAndNothingElse) {
    Shape ball = bumpyBall();
    MeshData mesh;
    mesh.restPositions = ball.positions, mesh.triangles = ball.triangles;
    mesh.restPositions.push_back(Vec3f(9));  // of no triangle
    const uint32_t vertices = uint32_t(mesh.restPositions.size());
    mesh.colours.resize(vertices), mesh.jointIndices.resize(vertices), mesh.jointWeights.resize(vertices);
    for (uint32_t v = 0; v < vertices; ++v) mesh.jointIndices[v].x = uint16_t(v);
    mesh.layers = {{"body", "body", 0, vertices, 0, uint32_t(mesh.triangles.size())}};
    const auto atlas = layOutAtlas(mesh.restPositions, mesh.triangles, ball.kind, 512);
    ASSERT_TRUE(atlas) << atlas.error().message;
    const SeamedMesh seamed = splitAtSeams(mesh, *atlas);
    EXPECT_GT(seamed.old.size(), ball.positions.size());
    EXPECT_EQ(seamed.mesh.layers[0].vertexCount, seamed.old.size());
    ASSERT_EQ(seamed.mesh.triangles.size(), mesh.triangles.size());
    std::set<std::pair<uint32_t, uint32_t>> wanted;
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = seamed.mesh.triangles[t][k];
            EXPECT_EQ(seamed.old[v], mesh.triangles[t][k]);
            EXPECT_EQ(seamed.mesh.restPositions[v], mesh.restPositions[mesh.triangles[t][k]]);
            EXPECT_EQ(seamed.mesh.jointIndices[v].x, mesh.triangles[t][k]);
            EXPECT_LT(glm::length(seamed.uv[v] * 512.0f - atlas->corners[t][k]), 1e-3f);
            wanted.insert({mesh.triangles[t][k], atlas->chart[t]});
        }
    EXPECT_EQ(seamed.old.size(), wanted.size());
}

TEST(MeshAtlas, refusesOtherSizesAndWhatHasNoPlace) {
    Shape ball = bumpyBall(6, 8);
    for (const uint32_t side : {0u, 100u, 128u, 1000u, 16384u}) {
        const auto atlas = layOutAtlas(ball.positions, ball.triangles, ball.kind, side);
        ASSERT_FALSE(atlas) << side;
        EXPECT_NE(atlas.error().message.find("a power of two from 256 to 8192"), std::string::npos) << atlas.error().message;
    }
    EXPECT_FALSE(layOutAtlas(ball.positions, {}, {}, 256));
    const std::vector<Vec3f> point(3, Vec3f(1));
    const std::vector<Triangle> flat = {{0, 1, 2}};
    EXPECT_FALSE(layOutAtlas(point, flat, std::vector<AtlasKind>(1), 256));

    Shape scattered;  // more charts than a small picture has room for, whatever their size
    for (uint32_t t = 0; t < 1000; ++t) {
        const Vec3f at(float(t % 32), float(t / 32), 0);
        scattered.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
        for (const Vec3f& corner : {Vec3f(0), Vec3f(0.1f, 0, 0), Vec3f(0, 0.1f, 0)}) scattered.positions.push_back(at + corner);
    }
    scattered.kind.resize(1000);
    const auto crowded = layOutAtlas(scattered.positions, scattered.triangles, scattered.kind, 256);
    ASSERT_FALSE(crowded);
    EXPECT_NE(crowded.error().message.find("1000 parts"), std::string::npos) << crowded.error().message;
    EXPECT_NE(crowded.error().message.find("--texture-size"), std::string::npos) << crowded.error().message;
    EXPECT_TRUE(layOutAtlas(scattered.positions, scattered.triangles, scattered.kind, 2048));
}

TEST(AtlasPacking, shapesFillEachOthersHolesAndNeverOverlap) {
    BlockShape frame{4, 4, {1, 1, 1, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 1, 1, 1}}, square{2, 2, {1, 1, 1, 1}}, bar{4, 1, {1, 1, 1, 1}};
    const auto places = packShapes(std::vector{bar, square, frame, bar}, 5);
    ASSERT_TRUE(places) << "the square fits into the frame, one bar stands and one lies beside it";
    EXPECT_EQ((*places)[1].x, 1u);
    EXPECT_EQ((*places)[1].y, 1u);
    std::vector<int> taken(25, 0);
    const std::vector<BlockShape> shapes = {bar, square, frame, bar};
    for (size_t s = 0; s < shapes.size(); ++s) {
        const BlockShape turned = shapes[s].turned((*places)[s].quarterTurns);
        for (uint32_t y = 0; y < turned.rows; ++y)
            for (uint32_t x = 0; x < turned.columns; ++x)
                taken[((*places)[s].y + y) * 5 + (*places)[s].x + x] += turned.taken[y * turned.columns + x];
    }
    EXPECT_EQ(*std::max_element(taken.begin(), taken.end()), 1);
    EXPECT_FALSE(packShapes(std::vector{bar, bar}, 3));
    EXPECT_FALSE(packShapes(std::vector{frame, square, square, bar}, 4));
}

}  // namespace
}  // namespace dpl
