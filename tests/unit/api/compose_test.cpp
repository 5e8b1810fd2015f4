// SPDX-License-Identifier: Apache-2.0
// Composes a layer into every format of target and compares with the referee, in double precision.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "sdk/api/compose.h"
#include "tests/reference/composition.h"

namespace dpl::api {
namespace {

constexpr Composition kOver[] = {{DPL_FORMAT_RGBA8, true}, {DPL_FORMAT_RGBA8_SRGB, true}, {DPL_FORMAT_RGBA16F, true}};

using reference::encodeSrgb, reference::decodeSrgb, reference::TargetFormat;

double halfValue(uint16_t half) {
    return double(floatFromHalf(half));
}

/** Half the distance between neighbouring half floats at a magnitude. */
double halfUlp(double magnitude) {
    return std::ldexp(1, std::max(-24, std::ilogb(std::max(magnitude, 1e-9)) - 10) - 1);
}

using Rgba8 = std::array<uint8_t, 4>;
using Rgba16 = std::array<uint16_t, 4>;

Rgba8 composed8(const Rgba8& layer, const Composition& how, Rgba8 target) {
    composeRow(layer.data(), 1, how, target.data());
    return target;
}
Rgba16 composed16(const Rgba8& layer, const Composition& how, Rgba16 target) {
    composeRow(layer.data(), 1, how, reinterpret_cast<uint8_t*>(target.data()));
    return target;
}

/** A premultiplied pixel; alphas 0 and 255 are frequent. */
Rgba8 randomPixel(std::mt19937& random) {
    const auto below = [&](uint32_t n) { return uint8_t(random() % n); };
    const uint32_t kind = random() % 4;
    Rgba8 p{0, 0, 0, kind == 0 ? uint8_t(0) : kind == 1 ? uint8_t(255) : below(256)};
    for (size_t c = 0; c < 3; ++c) p[c] = below(p[3] + 1u);
    return p;
}

/** Half an 8-bit code plus the rounding of a float sum in linear light: at the dark end 1e-7 of light are 3e-4 codes. */
constexpr double kHalfCode = 0.5 + 1e-3;

TEST(Compose, eightBitsAreWithinHalfACodeOfDoublePrecision) {
    std::mt19937 random(7);
    double worst[2] = {};
    for (int i = 0; i < 400000; ++i) {
        const Rgba8 layer = randomPixel(random), target = randomPixel(random);
        for (const bool srgb : {false, true}) {
            for (const bool over : {false, true}) {
                const Rgba8 got = composed8(layer, {srgb ? DPL_FORMAT_RGBA8_SRGB : DPL_FORMAT_RGBA8, over}, target);
                const TargetFormat format = srgb ? TargetFormat::Rgba8Srgb : TargetFormat::Rgba8;
                const auto want =
                    reference::over(format, layer.data(), over ? reference::unpack(format, target.data()) : reference::StoredPixel{});
                for (size_t c = 0; c < 4; ++c) {
                    const double error = std::abs(got[c] - 255 * want[c]);
                    worst[srgb] = std::max(worst[srgb], error);
                    ASSERT_LE(error, kHalfCode) << "layer " << int(layer[c]) << '/' << int(layer[3]) << " target " << int(target[c])
                                                << (srgb ? " sRGB" : "") << (over ? " over" : "");
                }
            }
        }
    }
    EXPECT_GT(worst[0], 0.49) << "no case was hard";
    EXPECT_GT(worst[1], 0.49);
}

TEST(Compose, everySrgbByteComesBackAndEveryEncodedCodeIsTheNearest) {
    for (int v = 0; v < 256; ++v) {
        const uint8_t grey = uint8_t(v);
        const Rgba8 opaque{grey, grey, grey, 255}, other{13, 200, 77, 255};
        for (const Composition& how : {kOver[0], kOver[1]}) EXPECT_EQ(composed8(opaque, how, other), opaque) << v;
        EXPECT_EQ(composed8(opaque, {DPL_FORMAT_RGBA8_SRGB}, other), opaque) << v;
        const Rgba16 linear = composed16(opaque, kOver[2], {0x3C00, 0x4900, 0x7C00, 0x7E00});
        for (size_t c = 0; c < 3; ++c) EXPECT_EQ(std::lround(255 * encodeSrgb(halfValue(linear[c]))), v) << "f16 keeps every code apart";
        EXPECT_EQ(halfValue(linear[3]), 1.0) << "an opaque pixel replaces the target, even an infinite one";
        // Black at every alpha over this grey gives the encoder many values between the codes.
        for (int a = 1; a < 256; ++a) {
            const Rgba8 got = composed8({0, 0, 0, uint8_t(a)}, kOver[1], opaque);
            ASSERT_LE(std::abs(got[0] - 255 * encodeSrgb((1 - a / 255.0) * decodeSrgb(v / 255.0))), kHalfCode) << v << ' ' << a;
        }
    }
}

TEST(Compose, halvesAreWithinHalfAStepOfDoublePrecision) {
    std::mt19937 random(11);
    int denormal = 0, bright = 0;
    for (int i = 0; i < 400000; ++i) {
        const Rgba8 layer = randomPixel(random);
        Rgba16 target;
        for (uint16_t& h : target) h = uint16_t(random() % 0x7C00);  // any finite half ≥ 0, up to 65504
        const auto stored = reference::unpack(TargetFormat::Rgba16f, reinterpret_cast<const uint8_t*>(target.data()));
        for (const bool over : {false, true}) {
            const Rgba16 got = composed16(layer, {DPL_FORMAT_RGBA16F, over}, target);
            const auto want = reference::over(TargetFormat::Rgba16f, layer.data(), over ? stored : reference::StoredPixel{});
            for (size_t c = 0; c < 4; ++c) {
                ASSERT_LE(std::abs(halfValue(got[c]) - want[c]), halfUlp(want[c]) * (1 + 1e-3)) << want[c];
                denormal += want[c] > 0 && want[c]<6e-5, bright += want[c]> 1;
            }
        }
    }
    EXPECT_GT(denormal, 100);
    EXPECT_GT(bright, 100);
}

TEST(Compose, infiniteAndUndefinedHalvesStayWhatTheyAre) {
    const Rgba16 target{0x7C00, 0x7E00, 0xFC00, 0x3C00};
    const Rgba16 got = composed16({10, 10, 10, 100}, kOver[2], target);
    EXPECT_EQ(got[0], 0x7C00);
    EXPECT_TRUE(std::isnan(halfValue(got[1])));
    EXPECT_EQ(got[2], 0xFC00);
    EXPECT_EQ(composed16({0, 0, 0, 0}, kOver[2], target), target);
}

TEST(Compose, anEmptyLayerLeavesEveryTargetByteForByte) {
    std::mt19937 random(3);
    std::vector<uint8_t> target(8 * 1000), layer(4 * 1000, 0);
    for (uint8_t& b : target) b = uint8_t(random());
    for (const Composition& how : kOver) {
        std::vector<uint8_t> got = target;
        composeRow(layer.data(), 1000, how, got.data());
        EXPECT_EQ(got, target) << how.format;
    }
}

TEST(Compose, straightAlphaIsTheSameColourInEveryFormat) {
    std::mt19937 random(5);
    for (int i = 0; i < 100000; ++i) {
        const Rgba8 layer = randomPixel(random);
        const Rgba8 display = composed8(layer, {DPL_FORMAT_RGBA8, false, true}, {}),
                    srgb = composed8(layer, {DPL_FORMAT_RGBA8_SRGB, false, true}, {});
        const Rgba16 linear = composed16(layer, {DPL_FORMAT_RGBA16F, false, true}, {});
        EXPECT_EQ(display, srgb);
        EXPECT_EQ(display[3], layer[3]);
        EXPECT_NEAR(halfValue(linear[3]), layer[3] / 255.0, halfUlp(1));
        for (size_t c = 0; c < 3; ++c) {
            const double want = layer[3] == 0 ? 0 : double(layer[c]) / layer[3];
            ASSERT_LE(std::abs(display[c] - 255 * want), 0.5);
            ASSERT_LE(std::abs(halfValue(linear[c]) - decodeSrgb(want)), halfUlp(decodeSrgb(want)) * (1 + 1e-3));
        }
    }
}

TEST(Compose, colourAboveItsAlphaCountsAsWhite) {  // Doppel's renderers never produce such a pixel
    EXPECT_EQ(composed8({255, 20, 0, 20}, {DPL_FORMAT_RGBA8_SRGB, false}, {}),
              composed8({20, 20, 0, 20}, {DPL_FORMAT_RGBA8_SRGB, false}, {}));
    EXPECT_EQ(composed8({255, 20, 0, 20}, kOver[0], {255, 255, 255, 255}), (Rgba8{255, 255, 235, 255}));
}

TEST(Compose, pixelsMayLieAnywhere) {
    const Rgba8 layer{40, 30, 20, 128};
    std::array<uint8_t, 11> bytes{};
    const Rgba16 target{0x3800, 0x3400, 0x3000, 0x3C00};
    std::memcpy(bytes.data() + 1, target.data(), 8);
    composeRow(layer.data(), 1, kOver[2], bytes.data() + 1);
    Rgba16 got;
    std::memcpy(got.data(), bytes.data() + 1, 8);
    EXPECT_EQ(got, composed16(layer, kOver[2], target));
    EXPECT_EQ(bytes[0], 0);
    EXPECT_EQ(bytes[9], 0);
}

}  // namespace
}  // namespace dpl::api
