// SPDX-License-Identifier: Apache-2.0
// FLIP against statements of its paper. The numbers for flat pictures were worked out by hand from its formulas.
#include "apps/reference/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/reference/reference_file.h"

namespace dpl {
namespace {

constexpr uint32_t kSize = 48;

template <class Of>
std::vector<double> picture(Of&& of) {
    std::vector<double> out;
    for (uint32_t y = 0; y < kSize; ++y)
        for (uint32_t x = 0; x < kSize; ++x)
            for (int c = 0; c < 3; ++c) out.push_back(of(x, y, c));
    return out;
}

double meanOf(const std::vector<double>& map) {
    return std::accumulate(map.begin(), map.end(), 0.0) / double(map.size());
}
double meanFlip(const std::vector<double>& a, const std::vector<double>& b) {
    return meanOf(flipMap(a, b, kSize, kSize));
}

TEST(Flip, equalPicturesAreZeroAndOppositeOnesNearlyOne) {
    const auto black = picture([](auto, auto, int) { return 0.0; }), white = picture([](auto, auto, int) { return 1.0; });
    const auto green = picture([](auto, auto, int c) { return c == 1 ? 1.0 : 0.0; }),
               blue = picture([](auto, auto, int c) { return c == 2 ? 1.0 : 0.0; });
    EXPECT_EQ(meanFlip(white, white), 0);
    EXPECT_NEAR(meanFlip(black, white), 0.967, 0.002);  // lightness 100: 100^0.7 = 25.12 of 41.2, past the knee at 16.5
    EXPECT_NEAR(meanFlip(green, blue), 1, 1e-9);        // by definition the largest distance
    EXPECT_EQ(meanFlip(black, white), meanFlip(white, black));
}

TEST(Flip, whatTheEyeBlursCountsLess) {
    const auto grey = picture([](auto, auto, int) { return 0.5; });
    const auto wave = [](uint32_t period) {
        return picture([=](uint32_t x, uint32_t, int) { return 0.5 + 0.08 * (x / (period / 2) % 2 ? 1 : -1); });
    };
    const double fine = meanFlip(grey, wave(2)), coarse = meanFlip(grey, wave(16));
    EXPECT_LT(fine, 0.6 * coarse);
    EXPECT_GT(fine, 0);
}

TEST(Flip, anEdgeThatAppearsCountsMoreThanAFlatChange) {
    const auto grey = picture([](auto, auto, int) { return 0.5; });
    const auto lighter = picture([](auto, auto, int) { return 0.6; }),
               step = picture([](uint32_t x, auto, int) { return x < kSize / 2 ? 0.5 : 0.6; });
    const auto map = flipMap(grey, step, kSize, kSize);
    EXPECT_GT(map[kSize * 10 + kSize / 2], 1.1 * meanFlip(grey, lighter));  // although blur halves the colour change at the edge
    EXPECT_LT(map[kSize * 10 + 2], 1e-6);                                   // unchanged far from the edge
}

TEST(Flip, coveredPixelsAloneCount) {
    ReferencePicture want{kSize, kSize, picture([](auto, auto, int) { return 0.0; }), std::vector<double>(kSize * kSize, 0.0)};
    std::vector<uint8_t> have(kSize * kSize * 4, 0);
    EXPECT_EQ(coveredFlip(want, have), 0);
    for (uint32_t y = 20; y < 28; ++y)
        for (uint32_t x = 20; x < 28; ++x) {
            const size_t p = y * kSize + x;
            want.alpha[p] = 1, have[p * 4 + 3] = 255;
            for (size_t c = 0; c < 3; ++c) want.rgb[p * 3 + c] = 1, have[p * 4 + c] = 255;
        }
    EXPECT_EQ(coveredFlip(want, have), 0);
    have[(24 * kSize + 24) * 4] = 0;  // one pixel turns cyan
    const double one = coveredFlip(want, have);
    EXPECT_GT(one, 0.005);
    EXPECT_LT(one, 0.2);
    EXPECT_EQ(coveredFlip(want, std::vector<uint8_t>(4)), 1);
}

}  // namespace
}  // namespace dpl
