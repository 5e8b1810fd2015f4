// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/garment_cover.h"

#include <gtest/gtest.h>

namespace dpl {
namespace {

/** A flat square of cloth, one metre wide, facing +Z. Its corners and the diagonals that end on its border are the hard places. */
SurfaceMesh square() {
    constexpr uint32_t kCells = 10;
    SurfaceMesh mesh;
    for (uint32_t y = 0; y <= kCells; ++y)
        for (uint32_t x = 0; x <= kCells; ++x) mesh.positions.emplace_back(x / float(kCells), y / float(kCells), 0.0f);
    for (uint32_t y = 0; y < kCells; ++y)
        for (uint32_t x = 0; x < kCells; ++x) {
            const uint32_t v = y * (kCells + 1) + x;
            mesh.triangles.push_back({v, v + 1, v + kCells + 2});
            mesh.triangles.push_back({v, v + kCells + 2, v + kCells + 1});
        }
    return mesh;
}

TEST(GarmentCover, aPointBesideTheBorderIsNotCovered) {
    const GarmentCover cover(square());
    const Vec3f up(0, 0, 1);
    for (int k = 0; k <= 20; ++k) {
        const float along = 0.05f * float(k);
        EXPECT_FALSE(cover.heightOf({along, -0.03f, 0}, up)) << "below, at " << along;
        EXPECT_FALSE(cover.heightOf({along, 1.03f, 0.001f}, up)) << "above, at " << along;
        EXPECT_FALSE(cover.heightOf({-0.03f, along, 0}, up)) << "left, at " << along;
        EXPECT_FALSE(cover.heightOf({1.03f, along, -0.001f}, up)) << "right, at " << along;
    }
}

TEST(GarmentCover, aPointOverOrUnderTheClothHasItsHeight) {
    const GarmentCover cover(square());
    for (const float height : {-0.02f, 0.03f}) {
        const auto found = cover.heightOf({0.42f, 0.57f, height}, Vec3f(0, 0, 1));
        ASSERT_TRUE(found);
        EXPECT_NEAR(found->aboveM, height, 1e-6f);
    }
    EXPECT_FALSE(cover.heightOf({0.42f, 0.57f, 0.01f}, Vec3f(0, 0, -1))) << "it faces the other way";
    EXPECT_FALSE(cover.heightOf({0.42f, 0.57f, 0.06f}, Vec3f(0, 0, 1))) << "too far off";
}

}  // namespace
}  // namespace dpl
