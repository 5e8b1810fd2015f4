// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/published_score.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/must.h"
#include "tests/unit/recon_report/naive_scores.h"

namespace dpl {
namespace {

constexpr uint32_t kPublishedW = 40, kPublishedH = 33;

/** A person with a soft outline, and a drawing that differs, is half transparent in places and also paints beside the person. */
struct PublishedScene {
    ImageRgb8 truth{kPublishedW, kPublishedH, std::vector<uint8_t>(kPublishedW* kPublishedH * 3)};
    ImageGrey8 mask{kPublishedW, kPublishedH, std::vector<uint8_t>(kPublishedW* kPublishedH, 0)};
    std::vector<uint8_t> rgba = std::vector<uint8_t>(kPublishedW * kPublishedH * 4, 0);
    PublishedScene() {
        std::mt19937 random(5);
        for (uint32_t y = 0; y < kPublishedH; ++y)
            for (uint32_t x = 0; x < kPublishedW; ++x) {
                const size_t i = y * kPublishedW + x;
                for (size_t c = 0; c < 3; ++c) {
                    truth.pixels[3 * i + c] = uint8_t(30 + 4 * x + 20 * c + random() % 40);
                    rgba[4 * i + c] = uint8_t(truth.pixels[3 * i + c] + random() % 30);
                }
                const bool inside = x >= 8 && x < 30 && y >= 4 && y < 28;
                mask.pixels[i] = inside ? uint8_t(x == 8 ? 100 : 255) : uint8_t(0);
                rgba[4 * i + 3] = uint8_t(x < 34 ? 255 - random() % 60 : 0);
            }
    }
};

TEST(PublishedScore, equalsItsFormulas) {
    const PublishedScene s;
    const PublishedScore score = must(scoreAsPublished(s.rgba, s.truth, s.mask, nullptr));
    const auto drawn = test::publishedPixel(s.rgba, s.mask), truth = test::publishedPixel(s.truth, s.mask);
    // Pictures are held as floats, which moves PSNR by 1e-6 dB and SSIM by 2e-7 here.
    EXPECT_NEAR(score.psnrDb, test::naivePsnrDb(drawn, truth, kPublishedW, kPublishedH), 1e-4);
    EXPECT_NEAR(score.ssim, test::naiveSsim(drawn, truth, kPublishedW, kPublishedH), 1e-5);
    EXPECT_GT(score.psnrDb, 10);
    EXPECT_LT(score.psnrDb, 35);
    EXPECT_LT(score.ssim, 0.99);
    EXPECT_FALSE(score.lpips);
}

TEST(PublishedScore, nothingOutsideTheMaskCounts) {
    PublishedScene s;
    const PublishedScore before = must(scoreAsPublished(s.rgba, s.truth, s.mask, nullptr));
    for (size_t i = 0; i < s.mask.pixels.size(); ++i)
        if (s.mask.pixels[i] == 0) s.rgba[4 * i] ^= 255, s.rgba[4 * i + 3] = 255, s.truth.pixels[3 * i] ^= 255;
    const PublishedScore after = must(scoreAsPublished(s.rgba, s.truth, s.mask, nullptr));
    EXPECT_EQ(after.psnrDb, before.psnrDb);
    EXPECT_EQ(after.ssim, before.ssim);
}

TEST(PublishedScore, meansAreOverFrames) {
    const std::vector<PublishedScore> scores = {{20, 0.5, 0.25}, {30, 0.75, 0.5}};
    const auto mean = meanOf(scores);
    EXPECT_DOUBLE_EQ(mean->psnrDb, 25);
    EXPECT_DOUBLE_EQ(mean->ssim, 0.625);
    EXPECT_DOUBLE_EQ(*mean->lpips, 0.375);
    EXPECT_FALSE(meanOf(std::vector<PublishedScore>{{20, 0.5, 0.25}, {30, 0.75, std::nullopt}})->lpips);
    EXPECT_FALSE(meanOf({}));
}

TEST(PublishedScore, sizesMustFit) {
    const PublishedScene s;
    EXPECT_FALSE(scoreAsPublished(std::vector<uint8_t>(4), s.truth, s.mask, nullptr));
    const ImageRgb8 small{10, 40, std::vector<uint8_t>(1200)};
    const ImageGrey8 smallMask{10, 40, std::vector<uint8_t>(400)};
    EXPECT_FALSE(scoreAsPublished(std::vector<uint8_t>(1600), small, smallMask, nullptr));
}

}  // namespace
}  // namespace dpl
