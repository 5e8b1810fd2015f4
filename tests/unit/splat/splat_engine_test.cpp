// SPDX-License-Identifier: Apache-2.0
// Behaviour of the splat engine without the referee: sizes, empty input, culling, order, threads, numbers that are not finite.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "sdk/splat/splat_engine.h"

namespace dpl {
namespace {

Cameraf camera(uint32_t width, uint32_t height) {
    Cameraf c;
    c.widthPx = width, c.heightPx = height;
    c.fx = c.fy = float(width), c.cx = float(width) / 2, c.cy = float(height) / 2;
    return c;
}

StaticSplatData grey(size_t count) {
    StaticSplatData s;
    s.position.assign(count, Vec3f(0, 0, 2));
    s.rotation.assign(count, Quatf(1, 0, 0, 0));
    s.scaleM.assign(count, Vec3f(0.05f));
    s.opacity.assign(count, 0.5f);
    s.sh.assign(count * 3, 0.f);
    return s;
}

SplatImage draw(SplatEngine& engine, const StaticSplatData& splats, const Cameraf& camera, const BlendOptions& options = {}) {
    SplatImage image;
    engine.project(splats, camera, 0.3f);
    engine.bin();
    engine.blend(image, options);
    return image;
}

float maxAlpha(const SplatImage& image) {
    float a = 0;
    for (float x : image.alpha) a = std::max(a, x);
    return a;
}

TEST(SplatEngine, emptyInputGivesTransparentImage) {
    Jobs jobs(2);
    SplatEngine engine(jobs);
    const SplatImage image = draw(engine, grey(0), camera(33, 17));
    ASSERT_EQ(image.alpha.size(), 33u * 17u);
    ASSERT_EQ(image.rgb.size(), 3u * 33u * 17u);
    EXPECT_EQ(maxAlpha(image), 0);
}

TEST(SplatEngine, oneSplatIsOpaqueInItsMiddleAndGrey) {
    Jobs jobs(1);
    SplatEngine engine(jobs);
    const SplatImage image = draw(engine, grey(1), camera(65, 65));
    const size_t middle = 32 * 65 + 32;
    EXPECT_NEAR(image.alpha[middle], 0.5f, 1e-5f);
    EXPECT_NEAR(image.rgb[middle * 3], 0.25f, 1e-5f);
    EXPECT_EQ(image.alpha[0], 0);
}

TEST(SplatEngine, targetOfOnePixel) {
    Jobs jobs(2);
    SplatEngine engine(jobs);
    const SplatImage image = draw(engine, grey(5), camera(1, 1));
    ASSERT_EQ(image.alpha.size(), 1u);
    EXPECT_GT(image.alpha[0], 0.4f);
}

TEST(SplatEngine, targetOfNoPixelsIsEmpty) {
    Jobs jobs(1);
    SplatEngine engine(jobs);
    EXPECT_TRUE(draw(engine, grey(5), camera(0, 0)).alpha.empty());
}

TEST(SplatEngine, largeTarget) {
    Jobs jobs(2);
    SplatEngine engine(jobs);
    engine.project(grey(1), camera(8192, 8192), 0.3f);
    engine.bin();
    std::vector<uint8_t> rgba;  // 256 MiB; the float image would take 1 GiB
    engine.blendRgba8(rgba);
    ASSERT_EQ(rgba.size(), size_t(8192) * 8192 * 4);
    EXPECT_NEAR(rgba[(size_t(4096) * 8192 + 4096) * 4 + 3], 127.5, 1);
    EXPECT_EQ(rgba[3], 0);
}

TEST(SplatEngine, equalDepthsKeepSplatOrder) {
    constexpr size_t kCount = 100000;
    StaticSplatData s = grey(kCount);
    Jobs jobs(2);
    SplatEngine engine(jobs);
    draw(engine, s, camera(16, 16));
    const TileLists& tiles = engine.tiles();
    ASSERT_EQ(tiles.offset.back(), kCount);
    for (uint32_t i = 0; i < kCount; ++i) ASSERT_EQ(tiles.entries[i], i);
}

TEST(SplatEngine, sortsNearFirstAndTiesByIndex) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> depth(0.06f, 900.f);
    StaticSplatData s = grey(30000);
    for (size_t i = 0; i < s.count(); ++i) s.position[i] = {0, 0, i % 3 ? std::round(depth(random)) + 1 : depth(random)};
    for (Vec3f& scale : s.scaleM) scale = Vec3f(1.f);
    s.opacity.assign(s.count(), 0.9f);
    Jobs jobs(2);
    SplatEngine engine(jobs);
    draw(engine, s, camera(16, 16));
    const TileLists& tiles = engine.tiles();
    const auto projected = engine.projected();
    ASSERT_GT(tiles.offset.back(), 29000u);
    for (uint32_t i = 1; i < tiles.offset.back(); ++i) {
        const ProjectedSplat &a = projected[tiles.entries[i - 1]], &b = projected[tiles.entries[i]];
        ASSERT_TRUE(a.depthM < b.depthM || (a.depthM == b.depthM && a.splat < b.splat)) << i;
    }
}

TEST(SplatEngine, nothingBehindTheNearPlane) {
    StaticSplatData s = grey(3);
    s.position = {{0, 0, 0.049f}, {0, 0, -2}, {0, 0, 0}};
    Jobs jobs(1);
    SplatEngine engine(jobs);
    EXPECT_EQ(maxAlpha(draw(engine, s, camera(32, 32))), 0);
}

TEST(SplatEngine, hostileNumbersAreSkippedAndTheRestIsDrawn) {
    const float values[] = {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(),
                            3e38f,
                            -3e38f,
                            1e20f,
                            1e-38f,
                            0.f,
                            -1.f};
    StaticSplatData s = grey(1);
    for (float v : values)
        for (int field = 0; field < 12; ++field) {
            s.position.push_back({0.1f, 0, 2}), s.rotation.push_back(Quatf(1, 0, 0, 0)), s.scaleM.push_back(Vec3f(0.05f));
            s.opacity.push_back(0.5f), s.sh.insert(s.sh.end(), 3, 0.f);
            if (field < 3)
                s.position.back()[field] = v;
            else if (field < 6)
                s.scaleM.back()[field - 3] = v;
            else if (field < 10)
                s.rotation.back()[field - 6] = v;
            else if (field == 10)
                s.opacity.back() = v;
            else
                s.sh.back() = v;
        }
    Jobs jobs(2);
    SplatEngine engine(jobs);
    const SplatImage image = draw(engine, s, camera(40, 40), {.cloth = true, .depth = true, .recordStops = true});
    for (size_t i = 0; i < image.alpha.size(); ++i) {
        ASSERT_TRUE(std::isfinite(image.alpha[i]) && image.alpha[i] >= 0 && image.alpha[i] <= 1) << i;
        for (int k = 0; k < 3; ++k) ASSERT_TRUE(std::isfinite(image.rgb[i * 3 + k])) << i;
        ASSERT_TRUE(std::isfinite(image.depthM[i]));
    }
    EXPECT_GT(image.alpha[20 * 40 + 20], 0.4f);
}

TEST(SplatEngine, stopsTellWhatWasBlended) {
    StaticSplatData s = grey(50);
    for (size_t i = 0; i < 50; ++i) s.position[i].z = 2 + 0.01f * float(i), s.opacity[i] = 0.9f;
    Jobs jobs(1);
    SplatEngine engine(jobs);
    const SplatImage image = draw(engine, s, camera(17, 17), {.recordStops = true});
    ASSERT_EQ(engine.stops().size(), 17u * 17u);
    const size_t middle = 8 * 17 + 8;
    // (1 − α)ⁿ ≤ 1e-4 with α slightly below 0.9 at the pixel centre: the fourth or fifth entry ends the pixel.
    EXPECT_GE(engine.stops()[middle], 4u);
    EXPECT_LE(engine.stops()[middle], 5u);
    EXPECT_LE(engine.stopTransmittance()[middle], 1e-4f);
    EXPECT_GT(engine.stopTransmittance()[middle], 1e-6f);
    EXPECT_NEAR(1 - image.alpha[middle], engine.stopTransmittance()[middle], 1e-6f);
}

TEST(SplatEngine, packedSplatsGiveTheSameBytes) {
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    StaticSplatData s = grey(5003);  // not a whole number of packed groups
    s.shDegree = 2;
    s.sh.assign(s.count() * 27, 0.f);
    for (float& x : s.sh) x = 0.3f * normal(random);
    for (size_t i = 0; i < s.count(); ++i) s.position[i] = {normal(random), normal(random), 3 + normal(random)};
    Jobs jobs(2);
    SplatEngine engine(jobs);
    const SplatImage plain = draw(engine, s, camera(120, 90));
    const PackedSplats packed(s);
    SplatImage image;
    engine.project(packed, {}, camera(120, 90), 0.3f, false);
    engine.bin();
    engine.blend(image);
    EXPECT_GT(maxAlpha(plain), 0.5f);
    EXPECT_EQ(plain.rgb, image.rgb);
    EXPECT_EQ(plain.alpha, image.alpha);
}

StaticSplatData row() {
    StaticSplatData s = grey(40);
    for (size_t i = 0; i < s.count(); ++i) s.position[i] = {0.05f * float(i) - 1, 0.1f * float(i % 7), 2}, s.sh[i * 3] = 0.1f * float(i);
    return s;
}

TEST(SplatEngine, rgba8IsTheFloatImageRounded) {
    for (const uint32_t samples : {1u, kCoverageSamples}) {
        Jobs jobs(2);
        SplatEngine engine(jobs);
        engine.project(PackedSplats(row()), {}, camera(61, 47), 0.3f, false, samples);  // partial tiles at both borders
        engine.bin();
        SplatImage image;
        engine.blend(image, {.depth = true});
        std::vector<uint8_t> rgba;
        std::vector<float> depth;
        engine.blendRgba8(rgba, &depth);
        ASSERT_EQ(rgba.size(), 61u * 47u * 4u);
        EXPECT_GT(maxAlpha(image), 0.4f);
        for (size_t i = 0; i < image.alpha.size(); ++i) {
            for (int k = 0; k < 3; ++k) ASSERT_NEAR(rgba[i * 4 + size_t(k)], image.rgb[i * 3 + size_t(k)] * 255, 0.501f);
            ASSERT_NEAR(rgba[i * 4 + 3], image.alpha[i] * 255, 0.501f);
        }
        EXPECT_EQ(depth, image.depthM);
    }
}

TEST(SplatEngine, fourSamplesAreTheMeanOfFourPicturesTakenASampleAside) {
    Jobs jobs(2);
    SplatEngine engine(jobs);
    const PackedSplats splats(row());
    const Cameraf view = camera(61, 47);
    SplatImage four, one;
    engine.project(splats, {}, view, 0.3f, true, kCoverageSamples);
    engine.bin();
    engine.blend(four);
    std::vector<float> rgb(four.rgb.size()), alpha(four.alpha.size());
    for (const auto& place : kCoverageSamplePx) {
        Cameraf aside = view;
        aside.cx += 0.5f - place[0], aside.cy += 0.5f - place[1];
        engine.project(splats, {}, aside, 0.3f / 4, true);
        engine.bin();
        engine.blend(one);
        for (size_t i = 0; i < rgb.size(); ++i) rgb[i] += one.rgb[i] / 4;
        for (size_t i = 0; i < alpha.size(); ++i) alpha[i] += one.alpha[i] / 4;
    }
    EXPECT_GT(maxAlpha(four), 0.3f);
    for (size_t i = 0; i < rgb.size(); ++i) ASSERT_NEAR(four.rgb[i], rgb[i], 2e-6f);
    for (size_t i = 0; i < alpha.size(); ++i) ASSERT_NEAR(four.alpha[i], alpha[i], 2e-6f);
}

TEST(SplatEngine, stopsAreRecordedWithOneSampleOnly) {
    Jobs jobs(1);
    SplatEngine engine(jobs);
    SplatImage image;
    for (const uint32_t samples : {1u, kCoverageSamples}) {
        engine.project(PackedSplats(row()), {}, camera(61, 47), 0.3f, false, samples);
        engine.bin();
        engine.blend(image, {.recordStops = true});
        EXPECT_EQ(engine.stops().size(), samples == 1 ? 61u * 47u : 0u);
        EXPECT_EQ(engine.stopTransmittance().size(), engine.stops().size());
    }
}

TEST(SplatEngine, arraysOfDifferentLengthDrawNothing) {
    StaticSplatData s = grey(20);
    s.sh.pop_back();
    Jobs jobs(1);
    SplatEngine engine(jobs);
    EXPECT_EQ(maxAlpha(draw(engine, s, camera(32, 32))), 0);
    EXPECT_EQ(PackedSplats(s).count(), 0u);
    s = grey(20);
    s.shDegree = 4;
    s.sh.assign(20 * 75, 0.f);
    EXPECT_EQ(maxAlpha(draw(engine, s, camera(32, 32))), 0);
}

TEST(SplatEngine, tooManyTileEntriesDrawTheNearest) {
    // 600 layers over 512 × 512 tiles would be 1.6e8 entries, more than the limit of 2²⁷. The nearest splats must be kept.
    StaticSplatData s = grey(600);
    for (size_t i = 0; i < s.count(); ++i) s.position[i].z = 3 - 0.001f * float(i), s.scaleM[i] = Vec3f(30.f);
    Jobs jobs(2);
    SplatEngine engine(jobs);
    engine.project(s, camera(8192, 8192), 0.3f);
    engine.bin();
    const TileLists& tiles = engine.tiles();
    EXPECT_LE(tiles.offset.back(), 1u << 27);
    EXPECT_GT(tiles.offset.back(), 1u << 26);
    EXPECT_EQ(tiles.entries[0], 599u);
}

TEST(SplatEngine, sameBytesOnOneTwoAndThreeThreads) {
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    StaticSplatData s = grey(40000);
    s.shDegree = 1;
    s.sh.assign(s.count() * 12, 0.f);
    for (float& x : s.sh) x = 0.3f * normal(random);
    for (size_t i = 0; i < s.count(); ++i) {
        s.position[i] = {normal(random), normal(random), 3 + normal(random)};
        s.scaleM[i] = Vec3f(0.01f) * std::exp(normal(random));
    }
    SplatImage images[3];
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        Jobs jobs(threads);
        SplatEngine engine(jobs);
        images[threads - 1] = draw(engine, s, camera(203, 151), {.cloth = true, .depth = true});
    }
    EXPECT_GT(maxAlpha(images[0]), 0.9f);
    for (int k = 1; k < 3; ++k) {
        EXPECT_EQ(images[0].rgb, images[k].rgb);
        EXPECT_EQ(images[0].alpha, images[k].alpha);
        EXPECT_EQ(images[0].depthM, images[k].depthM);
    }
}

}  // namespace
}  // namespace dpl
