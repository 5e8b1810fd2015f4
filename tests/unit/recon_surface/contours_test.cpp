// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/contours.h"

#include <cmath>

#include <gtest/gtest.h>

namespace dpl {
namespace {

std::vector<uint8_t> disc(uint32_t size, double cx, double cy, double radius) {
    std::vector<uint8_t> inside(size * size, 0);
    for (uint32_t y = 0; y < size; ++y)
        for (uint32_t x = 0; x < size; ++x) inside[y * size + x] = std::hypot(x + 0.5 - cx, y + 0.5 - cy) < radius;
    return inside;
}

TEST(Contours, aDiscsOutlineLiesOnItsCircleAndPointsOut) {
    const auto points = contourPoints(disc(64, 32, 32, 20), 64, 64);
    ASSERT_GT(points.size(), 100u);
    for (const auto& p : points) {
        const Vec2d d = p.px - Vec2d(32);
        EXPECT_NEAR(glm::length(d), 20, 0.8);
        EXPECT_GT(glm::dot(p.normal, glm::normalize(d)), 0.9);
    }
}

TEST(Contours, thePicturesEdgeIsNoOutline) {
    EXPECT_TRUE(contourPoints(std::vector<uint8_t>(16 * 16, 1), 16, 16).empty());
    EXPECT_TRUE(contourPoints(std::vector<uint8_t>(16 * 16, 0), 16, 16).empty());
}

TEST(Contours, theTwoSidesOfABarAreNotConfused) {
    // A bar of 6 px and the same bar shifted by 4 px: the nearest outline of the left side is the other's right side, 2 px away.
    std::vector<uint8_t> a(64 * 64, 0), b(64 * 64, 0);
    for (uint32_t y = 8; y < 56; ++y)
        for (uint32_t x = 20; x < 26; ++x) a[y * 64 + x] = b[y * 64 + x + 4] = 1;
    const auto from = contourPoints(b, 64, 64), to = contourPoints(a, 64, 64);
    const auto match = matchContours(from, to, 20, 5);
    for (size_t i = 0; i < from.size(); ++i) {
        if (from[i].px.y < 14 || from[i].px.y > 50) continue;
        ASSERT_NE(match[i], UINT32_MAX);
        EXPECT_NEAR(from[i].px.x - to[match[i]].px.x, 4, 1e-9);
    }
    EXPECT_EQ(matchContours(from, {}, 20, 5)[0], UINT32_MAX);
}

}  // namespace
}  // namespace dpl
