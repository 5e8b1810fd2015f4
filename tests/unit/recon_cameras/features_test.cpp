// SPDX-License-Identifier: Apache-2.0
// Features lie where the picture has them, in Doppel's pixels, and pictures of one texture match.
#include "reconstruction/input/cameras/features.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/recon_cameras/made_cameras.h"

namespace dpl {
namespace {

constexpr uint32_t kWidth = 200, kHeight = 160;

/** Soft spots of several sizes on grey; `shift` moves them. */
std::vector<uint8_t> spots(const std::vector<Vec2d>& centres, const Vec2d& shift) {
    std::vector<uint8_t> pixels(kWidth * kHeight, 100);
    for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) {
            double value = 100;
            for (size_t i = 0; i < centres.size(); ++i) {
                const Vec2d d = Vec2d(x + 0.5, y + 0.5) - centres[i] - shift;
                const double sigma = 2 + double(i % 4);
                value += 140 * std::exp(-glm::dot(d, d) / (2 * sigma * sigma)) * (i % 2 ? 1 : -0.6);
            }
            pixels[y * kWidth + x] = uint8_t(std::clamp(value, 0.0, 255.0));
        }
    return pixels;
}

std::vector<Vec2d> someCentres() {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> x(15, kWidth - 15), y(15, kHeight - 15);
    std::vector<Vec2d> centres;
    for (int i = 0; i < 40; ++i) centres.emplace_back(x(random), y(random));
    return centres;
}

TEST(Features, spotIsFoundAtItsCentre) {
    const Vec2d centre(100.3, 80.7);
    const auto pixels = spots({centre}, {0, 0});
    const Features found = findFeatures({kWidth, kHeight, pixels}, {}, 100, 1000);
    ASSERT_GT(found.size(), 0u);
    double nearest = INFINITY;
    for (const Vec2d& px : found.px) nearest = std::min(nearest, glm::length(px - centre));
    EXPECT_LT(nearest, 0.1);  // 0.35 px without the correction for the doubled picture
}

TEST(Features, shiftedTextureMatchesByItsShift) {
    const auto a = spots(someCentres(), {0, 0}), b = spots(someCentres(), {3.5, -2.25});
    const Features fa = findFeatures({kWidth, kHeight, a}, {}, 500, 1000), fb = findFeatures({kWidth, kHeight, b}, {}, 500, 1000);
    const auto matches = matchFeatures(fa, fb);
    ASSERT_GT(matches.size(), 15u);
    size_t right = 0;
    for (const FeatureMatch& m : matches) right += glm::length(fb.px[m.b] - fa.px[m.a] - Vec2d(3.5, -2.25)) < 0.5;
    EXPECT_GT(right * 10, matches.size() * 8) << right << " of " << matches.size();
    EXPECT_TRUE(matchFeatures(fa, {}).empty());
    EXPECT_TRUE(matchFeatures({}, fb).empty());
}

TEST(Features, nothingIsFoundWhereTheMaskIsZero) {
    const auto pixels = spots(someCentres(), {0, 0});
    std::vector<uint8_t> mask(kWidth * kHeight, 0);
    for (uint32_t y = 0; y < kHeight; ++y) std::fill_n(mask.begin() + y * kWidth, kWidth / 2, uint8_t(255));
    const Features found = findFeatures({kWidth, kHeight, pixels}, {kWidth, kHeight, mask}, 500, 1000);
    ASSERT_GT(found.size(), 5u);
    for (const Vec2d& px : found.px) EXPECT_LE(px.x, kWidth / 2 + 1);
}

TEST(Features, largePicturesAreSearchedSmaller) {
    const auto pixels = spots({{30, 30}, {170, 30}, {30, 130}, {100.3, 80.7}}, {0, 0});  // the last is large enough to be seen at half size
    const Features found = findFeatures({kWidth, kHeight, pixels}, {}, 100, 100);
    ASSERT_GT(found.size(), 0u);
    double nearest = INFINITY;
    for (const Vec2d& px : found.px) nearest = std::min(nearest, glm::length(px - Vec2d(100.3, 80.7)));
    EXPECT_LT(nearest, 0.5);  // half a pixel of the picture is a quarter of one of the small picture
}

TEST(Features, sizesThatDoNotFitGiveNone) {
    const auto pixels = spots(someCentres(), {0, 0});
    EXPECT_EQ(findFeatures({kWidth, kHeight + 1, pixels}, {}, 100, 1000).size(), 0u);
    EXPECT_EQ(findFeatures({kWidth, kHeight, pixels}, {kWidth - 1, kHeight, pixels}, 100, 1000).size(), 0u);
    EXPECT_EQ(findFeatures({}, {}, 100, 1000).size(), 0u);
}

TEST(Features, pinholePixelsUndoTheLens) {
    Camerad camera = orbit(1)[0];
    const LensDistortion lens{0.08, -0.02};
    for (const Vec2d& pinhole : {Vec2d(20, 30), Vec2d(189, 252), Vec2d(370, 480)}) {
        const double x = (pinhole.x - camera.cx) / camera.fx, y = (pinhole.y - camera.cy) / camera.fy, r2 = x * x + y * y;
        const double scale = 1 + lens.k1 * r2 + lens.k2 * r2 * r2;
        const std::vector<Vec2d> stored{{camera.fx * x * scale + camera.cx, camera.fy * y * scale + camera.cy}};
        const Vec2d back = pinholePixels(stored, camera, lens)[0];
        EXPECT_LT(glm::length(back - pinhole), 1e-6);
    }
}

}  // namespace
}  // namespace dpl
