// SPDX-License-Identifier: Apache-2.0
// The score of one label: an error counts for the label that shows it, and an outline for the label that lies next to it.
#include "reconstruction/judging/report/label_score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace dpl {
namespace {

constexpr uint32_t kLabelSide = 40;
constexpr uint8_t kHair = 4, kTop = 2;

/** A person from x = 10 to 29: hair above y = 20, a top below. */
struct LabelledScene {
    std::vector<uint8_t> truth = std::vector<uint8_t>(kLabelSide * kLabelSide * 4, 60), drawn;
    ImageGrey8 labels{kLabelSide, kLabelSide, std::vector<uint8_t>(kLabelSide* kLabelSide, 0)};

    LabelledScene() {
        for (uint32_t y = 0; y < kLabelSide; ++y)
            for (uint32_t x = 0; x < kLabelSide; ++x) {
                const bool person = x >= 10 && x < 30 && y >= 5 && y < 35;
                truth[(y * kLabelSide + x) * 4 + 3] = person ? 255 : 0;
                labels.pixels[y * kLabelSide + x] = person ? (y < 20 ? kHair : kTop) : 0;
            }
        drawn = truth;
    }
    void draw(const std::function<bool(uint32_t x, uint32_t y)>& where, const std::array<uint8_t, 4>& rgba) {
        for (uint32_t y = 0; y < kLabelSide; ++y)
            for (uint32_t x = 0; x < kLabelSide; ++x)
                if (where(x, y)) std::copy(rgba.begin(), rgba.end(), drawn.begin() + (y * kLabelSide + x) * 4);
    }
    LabelScore score(uint8_t label) const {
        const auto found = scoreLabel(drawn, truth, labels, label);
        EXPECT_TRUE(found);
        return found.value_or(LabelScore{});
    }
};

TEST(ScoreLabel, isPerfectForTheTruth) {
    const LabelledScene s;
    EXPECT_EQ(s.score(kHair).maskedPsnrDb, 100);
    EXPECT_EQ(s.score(kHair).outlineIou, 1);
}

TEST(ScoreLabel, anErrorCountsForItsOwnLabelAlone) {
    LabelledScene s;
    s.draw([](uint32_t x, uint32_t y) { return x >= 10 && x < 30 && y >= 20 && y < 35; }, {85, 85, 85, 255});  // the top, 25 too bright
    EXPECT_NEAR(s.score(kTop).maskedPsnrDb, -20 * std::log10(25 / 255.0), 1e-9);
    EXPECT_EQ(s.score(kHair).maskedPsnrDb, 100);
    EXPECT_EQ(s.score(kTop).outlineIou, 1);
}

TEST(ScoreLabel, aHoleCountsOnItsWorstBackground) {
    LabelledScene s;
    s.draw([](uint32_t x, uint32_t y) { return x >= 10 && x < 30 && y >= 5 && y < 20; }, {60, 60, 60, 0});
    EXPECT_NEAR(s.score(kHair).maskedPsnrDb, -20 * std::log10(195 / 255.0), 1e-9) << "on white";
}

TEST(ScoreLabel, anOutlineBelongsToTheNearestLabel) {
    LabelledScene s;
    s.draw([](uint32_t x, uint32_t y) { return x >= 30 && x < 34 && y >= 5 && y < 20; }, {60, 60, 60, 255});  // hair, 4 px too wide
    EXPECT_NEAR(s.score(kHair).outlineIou, 20.0 / 24, 0.01);
    EXPECT_NEAR(s.score(kTop).outlineIou, 1, 0.01);
}

TEST(ScoreLabel, tellsNothingOfALabelThatIsHardlyShown) {
    LabelledScene s;
    for (uint8_t& label : s.labels.pixels)
        if (label == kHair) label = kTop;
    EXPECT_FALSE(scoreLabel(s.drawn, s.truth, s.labels, kHair));
    s.labels.pixels.pop_back();
    EXPECT_FALSE(scoreLabel(s.drawn, s.truth, s.labels, kTop)) << "labels of another size";
}

}  // namespace
}  // namespace dpl
