// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstruction/judging/report/score.h"

namespace dpl::test {
namespace {

constexpr uint32_t kSize = 100;

struct Case {
    std::vector<uint8_t> drawn;
    ImageRgb8 truth{kSize, kSize, {}};
    ImageGrey8 mask{kSize, kSize, {}};
};

/** A texture inside a disc; the truth is `light(x, y, channel)` times it, and garbage outside of the disc. */
template <class Light>
Case make(Light light) {
    Case c;
    for (uint32_t y = 0; y < kSize; ++y)
        for (uint32_t x = 0; x < kSize; ++x) {
            const bool person = std::hypot(double(x) - 50, double(y) - 50) < 40;
            for (uint32_t k = 0; k < 3; ++k) {
                const double texture = 60 + 40 * std::sin(0.9 * x + k) * std::cos(1.1 * y);
                c.drawn.push_back(uint8_t(texture));
                c.truth.pixels.push_back(person ? uint8_t(uint8_t(texture) * light(x, y, k) + 0.5) : 255);
            }
            c.drawn.push_back(255);
            c.mask.pixels.push_back(person ? 255 : 0);
        }
    return c;
}

TEST(Light, aGainPerChannelIsFound) {
    const Case c = make([](uint32_t, uint32_t, uint32_t k) { return 0.8 + 0.3 * k; });
    EXPECT_LT(scorePicture(c.drawn, c.truth, c.mask).maskedPsnrDb, 25);
    EXPECT_GT(scorePicture(withBestGain(c.drawn, c.truth, c.mask), c.truth, c.mask).maskedPsnrDb, 50) << "rounding alone is left";
}

TEST(Light, aSmoothLightIsFoundAndAGainIsNotEnough) {
    const Case c = make([](uint32_t x, uint32_t, uint32_t) { return 0.6 + 0.008 * x; });
    const double before = scorePicture(c.drawn, c.truth, c.mask).maskedPsnrDb,
                 gain = scorePicture(withBestGain(c.drawn, c.truth, c.mask), c.truth, c.mask).maskedPsnrDb,
                 light = scorePicture(withBestLight(c.drawn, c.truth, c.mask, 0.04), c.truth, c.mask).maskedPsnrDb;
    EXPECT_GT(light, gain + 10);
    EXPECT_GE(gain, before);
}

/** dB that the best light brings in a window. */
double gainDb(const Case& c, double window) {
    return scorePicture(withBestLight(c.drawn, c.truth, c.mask, window), c.truth, c.mask).maskedPsnrDb -
           scorePicture(c.drawn, c.truth, c.mask).maskedPsnrDb;
}

TEST(Light, aNarrowWindowFindsFoldsThatAWideOneDoesNot) {
    const Case c = make([](uint32_t x, uint32_t, uint32_t) { return 1 + 0.4 * std::sin(0.3 * x); });  // folds of 21 pixels
    EXPECT_LT(gainDb(c, 0.20), 1);
    EXPECT_GT(gainDb(c, 0.02), 8);
}

TEST(Light, aNarrowWindowGainsOnNoiseToo) {
    // Nothing lacks light here, so whatever a window gains is overfit: more, the narrower it is.
    uint32_t state = 1;
    const Case c =
        make([&](uint32_t, uint32_t, uint32_t) { return 0.8 + 0.4 * double((state = state * 1664525u + 1013904223u) >> 8) / (1 << 24); });
    EXPECT_NEAR(gainDb(c, 0.20), 0, 0.05);
    EXPECT_GT(gainDb(c, 0.008), 0.2);
    EXPECT_GT(gainDb(c, 0.008), gainDb(c, 0.04));
}

TEST(Light, anEmptyMaskChangesNothing) {
    Case c = make([](uint32_t, uint32_t, uint32_t) { return 1.2; });
    std::fill(c.mask.pixels.begin(), c.mask.pixels.end(), uint8_t(0));
    EXPECT_EQ(withBestGain(c.drawn, c.truth, c.mask), c.drawn);
    EXPECT_EQ(withBestLight(c.drawn, c.truth, c.mask, 0.04), c.drawn);
}

}  // namespace
}  // namespace dpl::test
