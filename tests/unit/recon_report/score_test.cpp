// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reconstruction/subject/surface/lone_parts.h"

namespace {

using namespace dpl;

constexpr uint32_t kWidth = 40, kHeight = 30;

struct Scene {
    ImageRgb8 truth{kWidth, kHeight, std::vector<uint8_t>(kWidth* kHeight * 3)};
    ImageGrey8 mask{kWidth, kHeight, std::vector<uint8_t>(kWidth* kHeight, 0)};
    std::vector<uint8_t> rgba = std::vector<uint8_t>(kWidth * kHeight * 4, 0);
    /** A person of 20×20 pixels with a colour gradient. The picture equals the truth. */
    Scene() {
        for (uint32_t y = 0; y < kHeight; ++y)
            for (uint32_t x = 0; x < kWidth; ++x) {
                const size_t i = y * kWidth + x;
                for (int c = 0; c < 3; ++c) truth.pixels[i * 3 + c] = uint8_t(40 + 5 * x + 10 * c);
                if (x < 10 || x >= 30 || y < 5 || y >= 25) continue;
                mask.pixels[i] = 255;
                for (int c = 0; c < 3; ++c) rgba[i * 4 + c] = truth.pixels[i * 3 + c];
                rgba[i * 4 + 3] = 255;
            }
    }
};

TEST(ScorePicture, theTruthItselfIsPerfect) {
    Scene s;
    const FrameScore score = scorePicture(s.rgba, s.truth, s.mask);
    EXPECT_DOUBLE_EQ(score.maskedPsnrDb, 100);
    EXPECT_NEAR(score.maskedSsim, 1, 1e-5);
    EXPECT_DOUBLE_EQ(score.alphaIou, 1);
    EXPECT_NEAR(score.coverage, 400.0 / 1200, 1e-12);
    EXPECT_DOUBLE_EQ(score.unionPsnrDb, 100);
    EXPECT_NEAR(score.unionSsim, 1, 1e-5);
    EXPECT_EQ(score.uncovered, 0);
    EXPECT_EQ(score.drawnOutside, 0);
}

TEST(ScorePicture, aKnownErrorGivesItsPsnr) {
    Scene s;
    for (size_t i = 0; i < s.rgba.size(); i += 4)
        if (s.rgba[i + 3])
            for (int c = 0; c < 3; ++c) s.rgba[i + c] += 10;
    EXPECT_NEAR(scorePicture(s.rgba, s.truth, s.mask).maskedPsnrDb, -20 * std::log10(10.0 / 255), 1e-4);  // compositing is in float
}

TEST(ScorePicture, aHoleCountsInFullOnItsWorstBackground) {
    Scene s;
    for (size_t i = 0; i < s.rgba.size(); i += 4) s.rgba[i + 3] = 0;  // nothing is drawn
    const FrameScore score = scorePicture(s.rgba, s.truth, s.mask);
    double white = 0, black = 0;
    for (size_t i = 0; i < s.mask.pixels.size(); ++i)
        for (int c = 0; c < 3 && s.mask.pixels[i]; ++c) {
            const double v = s.truth.pixels[i * 3 + c] / 255.0;
            white += (1 - v) * (1 - v), black += v * v;
        }
    EXPECT_NEAR(score.maskedPsnrDb, -10 * std::log10(std::max(white, black) / 1200), 1e-4);
    EXPECT_EQ(score.alphaIou, 0);
    EXPECT_EQ(score.uncovered, 1);
    EXPECT_EQ(score.drawnOutside, 0);
    EXPECT_EQ(score.unionPsnrDb, score.maskedPsnrDb) << "nothing is drawn outside";
    EXPECT_EQ(score.unionSsim, score.maskedSsim);
}

TEST(ScorePicture, drawingTooWideCountsInTheUnionAlone) {
    // Black paint on 5 columns of 20 pixels left of the person. On white it is as wrong as a pixel can be, and the union has 500 pixels.
    Scene s;
    for (uint32_t y = 5; y < 25; ++y)
        for (uint32_t x = 5; x < 10; ++x) s.rgba[(y * kWidth + x) * 4 + 3] = 255;
    const FrameScore score = scorePicture(s.rgba, s.truth, s.mask);
    EXPECT_DOUBLE_EQ(score.maskedPsnrDb, 100);
    EXPECT_NEAR(score.unionPsnrDb, -10 * std::log10(100.0 / 500), 1e-4);
    EXPECT_LT(score.unionSsim, score.maskedSsim - 0.1);
    EXPECT_DOUBLE_EQ(score.drawnOutside, 100.0 / 400);
    EXPECT_EQ(score.uncovered, 0);
}

TEST(ScorePicture, aSpeckFreeOfThePersonIsLoneAndOneThatTouchesItIsNot) {
    Scene s;
    const auto draw = [&](uint32_t x, uint32_t y, uint8_t alpha) { s.rgba[(y * kWidth + x) * 4 + 3] = alpha; };
    draw(9, 4, 255);  // touches the person's corner
    EXPECT_EQ(scorePicture(s.rgba, s.truth, s.mask).lonePx, 0);
    draw(2, 2, 255), draw(3, 2, kShownAlpha);
    draw(4, 2, kShownAlpha - 1);  // too faint to be seen
    EXPECT_EQ(scorePicture(s.rgba, s.truth, s.mask).lonePx, 2);
}

TEST(ScorePicture, drawingTooNarrowIsUncovered) {
    Scene s;
    for (uint32_t y = 5; y < 25; ++y) {
        s.rgba[(y * kWidth + 10) * 4 + 3] = 127;
        s.rgba[(y * kWidth + 11) * 4 + 3] = 128;
    }
    const FrameScore score = scorePicture(s.rgba, s.truth, s.mask);
    EXPECT_DOUBLE_EQ(score.uncovered, 20.0 / 400);
    EXPECT_EQ(score.drawnOutside, 0);
    EXPECT_EQ(score.unionPsnrDb, score.maskedPsnrDb);
}

TEST(ScorePicture, paintOutsideTheMaskLowersTheIouNotTheMaskedPsnr) {
    Scene s;
    for (uint32_t i = 0; i < 400; ++i) s.rgba[i * 4 + 3] = 255;
    const FrameScore score = scorePicture(s.rgba, s.truth, s.mask);
    EXPECT_DOUBLE_EQ(score.maskedPsnrDb, 100);
    EXPECT_LT(score.alphaIou, 0.7);
    EXPECT_LT(score.fullPsnrDb, 15);
}

TEST(AreaAveraged, weighsColoursByCoverageAndKeepsTheirBrightness) {
    // 4×2 pixels are averaged to 2×1. The left half has one opaque red and three empty pixels, the right half two red and two blue ones.
    const std::vector<uint8_t> rgba = {200, 0, 0, 255, 9, 9, 9, 0, 200, 0, 0,   255, 0,   0, 100, 255,
                                       9,   9, 9, 0,   9, 9, 9, 0, 0,   0, 100, 255, 200, 0, 0,   255};
    EXPECT_EQ(areaAveraged(rgba, 4, 2, 2, 1), (std::vector<uint8_t>{200, 0, 0, 64, 100, 0, 50, 255}));
}

TEST(ScorePicture, aHalfCoveredPixelIsTrueWhenThePictureHalfCoversIt) {
    Scene s;
    std::vector<uint8_t> truth = cutOut(s.truth, s.mask);
    const size_t edge = 4 * (10 * kWidth + 10);  // leftmost column of the person
    truth[edge + 3] = s.rgba[edge + 3] = 160;
    EXPECT_DOUBLE_EQ(scorePicture(s.rgba, truth, kWidth, kHeight).maskedPsnrDb, 100);
    EXPECT_LT(scorePicture(s.rgba, s.truth, s.mask).maskedPsnrDb, 40);  // with a binary mask the partial coverage is an error
}

TEST(InsideOutline, takesOnePixelAllRoundTheOpaquePart) {
    std::vector<uint8_t> picture(7 * 5 * 4, 9);
    for (uint32_t y = 0; y < 5; ++y)
        for (uint32_t x = 0; x < 7; ++x) picture[(y * 7 + x) * 4 + 3] = x == 0 || y == 4 ? 0 : x == 6 ? 200 : 255;
    const auto inside = insideOutline(picture, 7, 5);
    for (uint32_t y = 0; y < 5; ++y)
        for (uint32_t x = 0; x < 7; ++x) {
            EXPECT_EQ(inside[(y * 7 + x) * 4 + 3], x >= 2 && x <= 4 && y >= 1 && y <= 2 ? 255 : 0) << x << ' ' << y;
            EXPECT_EQ(inside[(y * 7 + x) * 4], 9);
        }
}

TEST(LabelColours, paintsTheMeanOfEachLabel) {
    Scene s;
    ImageGrey8 labels{kWidth, kHeight, std::vector<uint8_t>(kWidth * kHeight, 2)};
    LabelColours colours;
    colours.add(s.truth, s.mask, labels);
    const auto painted = colours.paint(s.mask, labels);
    const size_t inside = 10 * kWidth + 15;
    EXPECT_EQ(int(painted[inside * 4]), 138);  // mean of 40 + 5x over x = 10 … 29 is 137.5
    EXPECT_EQ(painted[inside * 4 + 3], 255);
    EXPECT_EQ(painted[3], 0);
}

}  // namespace
