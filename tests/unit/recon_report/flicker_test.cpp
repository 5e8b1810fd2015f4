// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/flicker.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dpl {
namespace {

constexpr uint32_t kSizePx = 64;

Camerad camera() {
    Camerad c;
    c.widthPx = c.heightPx = kSizePx;
    c.fx = c.fy = 64, c.cx = c.cy = 32;
    c.viewFromWorldTranslation = {0, 0, 1};  // one metre before the origin: a pixel is 1/64 m there
    return c;
}

const std::vector<Triangle> kSquare{{0, 1, 2}, {1, 3, 2}};

/** A square of 40 px at the origin, moved to the right. */
std::vector<Vec3f> square(float movedPx) {
    std::vector<Vec3f> positions;
    for (int i = 0; i < 4; ++i) positions.push_back({((i & 1 ? 20.0f : -20.0f) + movedPx) / 64, (i & 2 ? 20.0f : -20.0f) / 64, 0});
    return positions;
}

/** A picture with a pattern that moved to the right, brighter by some levels. */
std::vector<uint8_t> picture(double movedPx, int brighter = 0) {
    std::vector<uint8_t> rgba;
    for (uint32_t y = 0; y < kSizePx; ++y)
        for (uint32_t x = 0; x < kSizePx; ++x) {
            const double wave = 50 * std::sin(0.2 * (double(x) - movedPx)) + 30 * std::cos(0.15 * double(y));
            for (int c = 0; c < 3; ++c) rgba.push_back(uint8_t(std::lround(120 + wave) + brighter));
            rgba.push_back(255);
        }
    return rgba;
}

double flicker(double surfaceMovedPx, double pictureMovedPx, int brighter) {
    const auto first = picture(0), second = picture(pictureMovedPx, brighter);
    const auto from = square(0), to = square(float(surfaceMovedPx));
    return flickerLevels({first, from}, {second, to}, kSquare, camera()).value();
}

TEST(Flicker, aPatternThatMovesWithTheSurfaceDoesNotFlicker) {
    EXPECT_LT(flicker(3, 3, 0), 1e-3);
    EXPECT_LT(flicker(2.5, 2.5, 0), 0.6) << "rounding and interpolation";
}

TEST(Flicker, isTheChangeThatMotionDoesNotExplain) {
    EXPECT_NEAR(flicker(3, 3, 7), 7, 0.01) << "it became brighter";
    EXPECT_NEAR(flicker(0, 0, 7), 7, 0.01);
    EXPECT_GT(flicker(3, 0, 0), 15) << "the pattern stayed behind";
}

TEST(Flicker, whatIsHiddenInOnePictureDoesNotCount) {
    // A nearer square covers the right half in the second picture. What it shows is no change of the first.
    auto from = square(0), to = square(0);
    std::vector<Triangle> triangles = kSquare;
    for (const Triangle& t : kSquare) triangles.push_back(t + 4u);
    for (const Vec3f& p : square(0)) {
        from.push_back(p + Vec3f(100, 0, -0.3f));
        to.push_back({p.x < 0 ? 0.0f : p.x, p.y, -0.3f});
    }
    const auto first = picture(0);
    auto second = first;
    for (uint32_t y = 0; y < kSizePx; ++y)
        for (uint32_t x = 30; x < kSizePx; ++x) second[4 * (y * kSizePx + x)] = 0;
    const auto found = flickerLevels({first, from}, {second, to}, triangles, camera());
    ASSERT_TRUE(found);
    EXPECT_LT(*found, 30);
    const auto uncovered = flickerLevels({first, square(0)}, {second, square(0)}, kSquare, camera());
    ASSERT_TRUE(uncovered);
    EXPECT_GT(*uncovered, 2 * *found);
}

TEST(Flicker, needsASurface) {
    const auto shown = picture(0);
    const auto away = square(1000);
    EXPECT_FALSE(flickerLevels({shown, away}, {shown, away}, kSquare, camera()));
}

}  // namespace
}  // namespace dpl
