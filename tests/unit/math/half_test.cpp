// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "sdk/math/half.h"
#include "tests/not_finite.h"

namespace dpl {
namespace {

/** Value of a finite half by its definition. */
double valueOf(uint16_t half) {
    const int exponent = half >> 10 & 31, mantissa = half & 1023;
    const double magnitude = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
    return half & 0x8000 ? -magnitude : magnitude;
}

TEST(Half, everyHalfIsItsValueAndComesBack) {
    for (uint32_t h = 0; h < 0x10000; ++h) {
        const uint16_t half = uint16_t(h);
        const float x = floatFromHalf(half);
        if ((h & 0x7C00) == 0x7C00 && (h & 1023)) {
            EXPECT_TRUE(std::isnan(x));
            EXPECT_TRUE(std::isnan(floatFromHalf(halfFromFloat(x))));
            continue;
        }
        if ((h & 0x7FFF) == 0x7C00)
            ASSERT_EQ(x, h & 0x8000 ? -kInfinity : kInfinity);
        else
            ASSERT_EQ(double(x), valueOf(half)) << h;
        ASSERT_EQ(halfFromFloat(x), half) << h;
    }
    EXPECT_TRUE(std::signbit(floatFromHalf(0x8000)));
}

TEST(Half, roundsToNearestAndTiesToEven) {
    for (uint32_t h = 0; h < 0x7BFF; ++h) {
        const double low = valueOf(uint16_t(h)), high = valueOf(uint16_t(h + 1));
        const float middle = float((low + high) / 2);  // exact: a float has 13 bits more
        const uint32_t even = h % 2 ? h + 1 : h;
        ASSERT_EQ(halfFromFloat(middle), even) << h;
        ASSERT_EQ(halfFromFloat(-middle), even | 0x8000) << h;
        ASSERT_EQ(halfFromFloat(std::nextafter(middle, 0.0f)), h);
        ASSERT_EQ(halfFromFloat(std::nextafter(middle, 1e9f)), h + 1);
    }
}

TEST(Half, endsOfTheRange) {
    EXPECT_EQ(halfFromFloat(65504.0f), 0x7BFF);
    EXPECT_EQ(halfFromFloat(std::nextafter(65520.0f, 0.0f)), 0x7BFF);
    for (const float big : {65520.0f, 1e6f, std::numeric_limits<float>::max(), kInfinity}) {
        EXPECT_EQ(halfFromFloat(big), 0x7C00) << big;
        EXPECT_EQ(halfFromFloat(-big), 0xFC00) << big;
    }
    EXPECT_EQ(halfFromFloat(std::numeric_limits<float>::denorm_min()), 0);
    EXPECT_EQ(halfFromFloat(-std::numeric_limits<float>::min()), 0x8000);
    EXPECT_EQ(halfFromFloat(std::ldexp(1.0f, -25)), 0) << "half a step of a denormal: a tie";
    EXPECT_EQ(halfFromFloat(std::nextafter(std::ldexp(1.0f, -25), 1.0f)), 1);
    EXPECT_EQ(halfFromFloat(std::bit_cast<float>(0x7F800001u)) & 0x7C00, 0x7C00) << "a signalling NaN does not become infinite";
    EXPECT_NE(halfFromFloat(std::bit_cast<float>(0x7F800001u)) & 1023, 0);
}

}  // namespace
}  // namespace dpl
