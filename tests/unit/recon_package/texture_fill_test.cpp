// SPDX-License-Identifier: Apache-2.0
// Where nothing was seen, a texture goes on with what lies next to it.
#include "reconstruction/output/package/texture_fill.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dpl {
namespace {

constexpr uint32_t kSide = 64;

/** Red on the left, blue on the right, as two charts with eight columns between them and nothing around. */
std::vector<uint8_t> twoCharts(uint32_t rings) {
    TextureFill fill(kSide);
    for (uint32_t y = 20; y < 40; ++y)
        for (uint32_t x = 11; x < 51; ++x)
            if (x < 27 || x >= 35) fill.set(y * kSide + x, x < 27 ? Vec3f(1, 0, 0) : Vec3f(0, 0, 1));
    return fill.finish(rings);
}

TEST(TextureFill, gutterTexelsContinueTheirOwnChart) {
    const auto rgb = twoCharts(4);
    const auto at = [&](uint32_t x, uint32_t y) { return Vec3f(rgb[3 * (y * kSide + x)], 0, rgb[3 * (y * kSide + x) + 2]); };
    for (uint32_t x = 11; x < 31; ++x) EXPECT_EQ(at(x, 30), Vec3f(255, 0, 0)) << x;
    for (uint32_t x = 31; x < 51; ++x) EXPECT_EQ(at(x, 30), Vec3f(0, 0, 255)) << x;
}

TEST(TextureFill, mipmapsOfAChartHoldNoForeignColour) {
    const auto rgb = twoCharts(4);
    // Every block of 2 × 2 and 4 × 4 texels that touches a chart, as a viewer averages them.
    for (const uint32_t block : {2u, 4u})
        for (uint32_t by = 20 / block; by < 40 / block; ++by)
            for (uint32_t bx = 11 / block; bx < (27 + block - 1) / block; ++bx)
                for (uint32_t y = by * block; y < (by + 1) * block; ++y)
                    for (uint32_t x = bx * block; x < (bx + 1) * block; ++x) EXPECT_EQ(rgb[3 * (y * kSide + x)], 255) << x << " " << y;
    for (size_t p = 0; p < rgb.size(); p += 3) ASSERT_EQ(rgb[p] + rgb[p + 2] > 200, true) << "texel " << p / 3 << " was left black";
}

TEST(TextureFill, unseenVerticesTakeTheirNeighboursAndForeignPiecesTheirOwnColour) {
    MeshData mesh;  // a strip of six vertices, of which the first two were seen, and a triangle that touches nothing
    mesh.triangles = {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 5}, {6, 7, 8}};
    mesh.restPositions.resize(9);
    mesh.colours.assign(9, {0, 255, 0, 255});
    std::vector<Vec4f> seen(9, Vec4f(0));
    seen[0] = {2, 0, 0, 2}, seen[1] = {0, 0, 1, 1};
    const auto colours = spreadColours(seen, mesh);
    EXPECT_EQ(colours[0], Vec3f(1, 0, 0));
    EXPECT_EQ(colours[1], Vec3f(0, 0, 1));
    EXPECT_EQ(colours[2], Vec3f(0.5f, 0, 0.5f));
    EXPECT_EQ(colours[3], Vec3f(0, 0, 1)) << "of its ring, only vertex 1 was seen";
    EXPECT_EQ(colours[4], Vec3f(0.25f, 0, 0.75f));
    for (int v = 6; v < 9; ++v) EXPECT_EQ(colours[v], Vec3f(0, 1, 0));
}

}  // namespace
}  // namespace dpl
