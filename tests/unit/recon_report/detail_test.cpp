// SPDX-License-Identifier: Apache-2.0
// Correlation of fine detail: 1 for the same detail at any contrast, less for blur and shift, none for other detail.
#include "reconstruction/judging/report/detail.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace dpl {
namespace {

constexpr uint32_t kSide = 96;

/** A grey picture, opaque within a disc. */
std::vector<uint8_t> picture(const std::function<double(int x, int y)>& level) {
    std::vector<uint8_t> rgba(size_t(kSide) * kSide * 4);
    for (int y = 0; y < int(kSide); ++y)
        for (int x = 0; x < int(kSide); ++x) {
            uint8_t* p = rgba.data() + 4 * (size_t(y) * kSide + size_t(x));
            p[0] = p[1] = p[2] = uint8_t(std::clamp(std::lround(level(x, y)), 0L, 255L));
            p[3] = std::hypot(x - 48, y - 48) < 40 ? 255 : 0;
        }
    return rgba;
}

/** Waves of 5 to 9 px in all directions. */
double waves(double x, double y) {
    return 20 * std::sin(x * 1.1 + 0.3 * y) + 20 * std::sin(0.8 * y - 0.2 * x) + 15 * std::sin(0.5 * x + 0.6 * y);
}

double score(const std::vector<uint8_t>& drawn, const std::vector<uint8_t>& truth, std::span<const uint8_t> chosen = {}) {
    const auto r = detailCorrelation(drawn, truth, kSide, kSide, chosen);
    EXPECT_TRUE(r);
    return r.value_or(-9);
}

TEST(Detail, isOneForTheSameDetailAtAnyContrastAndBrightness) {
    const auto truth = picture([](int x, int y) { return 120 + waves(x, y); });
    EXPECT_NEAR(score(truth, truth), 1, 1e-9);
    EXPECT_GT(score(picture([](int x, int y) { return 60 + 0.5 * waves(x, y); }), truth), 0.995);
    EXPECT_GT(score(picture([](int x, int y) { return 120 + 0.8 * x + waves(x, y); }), truth), 0.99) << "light that falls from one side";
    EXPECT_LT(score(picture([](int x, int y) { return 120 - waves(x, y); }), truth), -0.995);
}

TEST(Detail, fallsWithAShift) {
    const auto truth = picture([](int x, int y) { return 120 + waves(x, y); });
    double before = 1;
    for (const double shift : {0.5, 1.0, 1.5}) {
        const double now = score(picture([=](int x, int y) { return 120 + waves(x + shift, y); }), truth);
        EXPECT_LT(now, before - 0.03) << shift << " px";
        before = now;
    }
}

TEST(Detail, isNoneForOtherDetailAndForAPlainPicture) {
    const auto truth = picture([](int x, int y) { return 120 + waves(x, y); });
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0, 25);
    EXPECT_NEAR(score(picture([&](int, int) { return 120 + noise(random); }), truth), 0, 0.08);
    EXPECT_EQ(score(picture([](int, int) { return 120.0; }), truth), 0);
}

TEST(Detail, theOutlineIsNoDetail) {
    // A plain truth on a dark background: the step of alpha would correlate perfectly.
    const auto plain = picture([](int, int) { return 240.0; });
    EXPECT_FALSE(detailCorrelation(plain, plain, kSide, kSide)) << "a truth without detail";
    const auto truth = picture([](int x, int y) { return 200 + 0.2 * waves(x, y); });
    EXPECT_EQ(score(plain, truth), 0);
}

TEST(Detail, countsTheChosenPixelsOnly) {
    const auto truth = picture([](int x, int y) { return 120 + waves(x, y); });
    const auto half = picture([](int x, int y) { return x < 48 ? 120 + waves(x, y) : 120 - waves(x, y); });
    std::vector<uint8_t> left(size_t(kSide) * kSide), right(left.size()), none(left.size());
    for (size_t i = 0; i < left.size(); ++i) left[i] = i % kSide<36, right[i] = i % kSide> 60;
    EXPECT_GT(score(half, truth, left), 0.999);
    EXPECT_LT(score(half, truth, right), -0.999);
    EXPECT_FALSE(detailCorrelation(half, truth, kSide, kSide, none));
}

TEST(Detail, refusesWrongSizes) {
    const auto truth = picture([](int x, int y) { return 120 + waves(x, y); });
    EXPECT_FALSE(detailCorrelation(truth, truth, kSide, kSide - 1));
    EXPECT_FALSE(detailCorrelation(truth, truth, 0, 0));
    EXPECT_FALSE(detailCorrelation(truth, truth, kSide, kSide, std::vector<uint8_t>(3, 1)));
}

}  // namespace
}  // namespace dpl
