// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/train_images.h"

#include <gtest/gtest.h>

#include <numeric>

namespace dpl {
namespace {

/** A frame with a picture that the test can change. */
struct Given : TrainFrame {
    std::shared_ptr<FramePicture> shown = std::make_shared<FramePicture>();
};

Given frame(uint32_t width, uint32_t height) {
    Given f;
    f.picture = LazyPicture(f.shown);
    f.name = "test";
    f.camera.widthPx = width, f.camera.heightPx = height, f.camera.fx = f.camera.fy = 100, f.camera.cx = width / 2.0,
    f.camera.cy = height / 2.0;
    f.shown->image = {width, height, std::vector<uint8_t>(size_t(width) * height * 3)};
    f.shown->mask = {width, height, std::vector<uint8_t>(size_t(width) * height, 0)};
    for (size_t i = 0; i < f.shown->image.pixels.size(); ++i) f.shown->image.pixels[i] = uint8_t((i * 37) % 251);
    return f;
}

TEST(LevelFrame, cropsToThePersonPlusTenPercentAndKeepsTheRays) {
    Given f = frame(200, 300);
    for (uint32_t y = 100; y < 200; ++y)
        for (uint32_t x = 60; x < 110; ++x) f.shown->mask.pixels[y * 200 + x] = 255;
    const LevelFrame full = makeLevelFrame(f, *f.shown, 1, {}, true);
    EXPECT_EQ(full.leftPx, 50u);
    EXPECT_EQ(full.topPx, 90u);
    EXPECT_EQ(full.widthPx, 70u);
    EXPECT_EQ(full.heightPx, 120u);
    EXPECT_FLOAT_EQ(full.kappaPx2, kTrainedKappaPx2);
    EXPECT_FLOAT_EQ(full.camera.cx, 50.0f);
    EXPECT_EQ(full.rgb[(10 * 70) + 10], f.shown->image.pixels[(100 * 200 + 60) * 3]) << "masked pixels are copied";
    EXPECT_EQ(full.rgb[0], 0) << "colour is premultiplied by the mask";
    EXPECT_EQ(std::accumulate(full.unsure.begin(), full.unsure.end(), 0), 255 * (2 * 50 + 2 * 98 + 2 * 50 + 2 * 100))
        << "the edge: one pixel inside, one outside";
    EXPECT_GT(full.edgeMaskWeight, 1);
    const LevelFrame half = makeLevelFrame(f, *f.shown, 0.5f, {}, false);
    EXPECT_EQ(half.widthPx, 35u);
    EXPECT_TRUE(half.unsure.empty()) << "a pixel is too wide here";
    EXPECT_FLOAT_EQ(half.camera.fx, 50.0f);
    EXPECT_FLOAT_EQ(half.kappaPx2, kTrainedKappaPx2) << "the same at every size";
    const Vec3f ray(0.1f, -0.2f, 1);
    const Vec2f a = full.camera.pixelOf(ray) + Vec2f(full.leftPx, full.topPx),
                b = half.camera.pixelOf(ray) + Vec2f(half.leftPx, half.topPx);
    EXPECT_NEAR(a.x, 2 * b.x, 1e-3);
    EXPECT_NEAR(a.y, 2 * b.y, 1e-3);
}

TEST(LevelFrame, areaAverageKeepsTheMean) {
    Given f = frame(97, 61);
    std::fill(f.shown->mask.pixels.begin(), f.shown->mask.pixels.end(), uint8_t(255));
    const LevelFrame level = makeLevelFrame(f, *f.shown, 0.37f, {}, false);
    double a = 0, b = 0;
    for (uint8_t v : f.shown->image.pixels) a += v;
    for (uint8_t v : level.rgb) b += v;
    EXPECT_NEAR(a / double(f.shown->image.pixels.size()), b / double(level.rgb.size()), 0.2);
}

/** Person and background of one colour each; the mask that networks found is a pixel too wide on the right. */
TEST(LevelFrame, foundMasksHaveAnUnsureEdge) {
    Given f = frame(400, 300);  // a radius of 4 px
    for (uint32_t y = 0; y < 300; ++y)
        for (uint32_t x = 0; x < 400; ++x)
            for (uint32_t c = 0; c < 3; ++c) f.shown->image.pixels[(y * 400 + x) * 3 + c] = x >= 150 && x < 250 ? 200 : 40;
    for (uint32_t y = 50; y < 250; ++y)
        for (uint32_t x = 150; x < 251; ++x) f.shown->mask.pixels[y * 400 + x] = 255;
    const LevelFrame given = makeLevelFrame(f, *f.shown, 1, {}, true);
    EXPECT_EQ(given.unsure[size_t(150 - given.topPx) * given.widthPx + 247 - given.leftPx], 0)
        << "masks that a scan brings are exact to a pixel";
    f.shown->maskFound = true;
    const LevelFrame full = makeLevelFrame(f, *f.shown, 1, {}, true);
    const auto at = [&](uint32_t x) { return size_t(150 - full.topPx) * full.widthPx + x - full.leftPx; };
    for (const uint32_t x : {146u, 149u, 150u, 153u, 247u, 250u, 251u, 254u}) {
        EXPECT_EQ(full.unsure[at(x)], 255) << x;
        EXPECT_EQ(full.behind[at(x)], 40) << x;
        EXPECT_EQ(full.shown[at(x)], 255) << x;
        EXPECT_EQ(full.rgb[at(x)], x >= 150 && x < 250 ? 200 : 40) << "the picture as it is, " << x;
    }
    for (const uint32_t x : {145u, 154u, 246u, 255u}) EXPECT_EQ(full.unsure[at(x)], 0) << x;
    EXPECT_EQ(full.rgb[at(200)], 200);
    EXPECT_EQ(full.shown[at(200)], 255);
    EXPECT_EQ(full.rgb[at(256)] + full.shown[at(256)], 0) << "background that is sure is random";
    EXPECT_EQ(full.edgeMaskWeight, 1) << "the mask is no surer than the picture";
    const LevelFrame half = makeLevelFrame(f, *f.shown, 0.5f, {}, false);
    EXPECT_GT(std::accumulate(half.unsure.begin(), half.unsure.end(), size_t(0)), size_t(0));
    std::fill(f.shown->mask.pixels.begin(), f.shown->mask.pixels.end(), uint8_t(255));
    f.shown->mask.pixels[0] = 0;
    const LevelFrame whole = makeLevelFrame(f, *f.shown, 1, {}, true);
    EXPECT_EQ(std::accumulate(whole.unsure.begin(), whole.unsure.end(), 0), 0) << "no background nearby: the mask decides";
}

TEST(LevelFrame, emptyMaskIsNotUsed) {
    const Given nobody = frame(20, 20);
    EXPECT_FALSE(makeLevelFrame(nobody, *nobody.shown, 1, {}, true).used);
}

TEST(LevelFrame, coarsestIs160PixelsOrATenth) {
    EXPECT_FLOAT_EQ(coarsestScale(frame(378, 504)), 160.0f / 378);
    EXPECT_FLOAT_EQ(coarsestScale(frame(100, 504)), 1.0f);
    EXPECT_FLOAT_EQ(coarsestScale(frame(4000, 3000)), 0.1f);
}

TEST(LevelFrame, wrongSizesNameTheFrame) {
    Given f = frame(20, 10);
    f.shown->mask.pixels.pop_back();
    const auto s = checkedPicture(f);
    ASSERT_FALSE(s);
    EXPECT_NE(s.error().message.find("'test'"), std::string::npos);
}

}  // namespace
}  // namespace dpl
