#include "reconstruction/splat/metrics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dpl {
namespace {

struct Picture {
    uint32_t width = 40, height = 30;
    std::vector<uint8_t> truth, mask;
    std::vector<float> rgb, alpha;
    Picture() {
        for (uint32_t y = 0; y < height; ++y)
            for (uint32_t x = 0; x < width; ++x) {
                const bool in = x >= 10 && x < 30 && y >= 5 && y < 25;
                mask.push_back(in ? 255 : 0), alpha.push_back(in ? 1.0f : 0.0f);
                for (uint32_t c = 0; c < 3; ++c) {
                    truth.push_back(uint8_t(100 + 5 * (x % 7) + 10 * c));
                    rgb.push_back(in ? float(truth.back()) / 255.0f : 0.0f);
                }
            }
    }
    ImageScores score() {
        Jobs jobs(1);
        return scoreImage({width, height, rgb, alpha}, {truth, mask}, jobs);
    }
};

TEST(ImageScores, perfectPicture) {
    const ImageScores s = Picture().score();
    EXPECT_EQ(s.worst.psnrMasked, kPerfectPsnr);
    EXPECT_NEAR(s.worst.ssim, 1, 1e-5);
    EXPECT_EQ(s.alphaIou, 1);
    EXPECT_NEAR(s.coverage, 400.0 / 1200.0, 1e-9);
}

TEST(ImageScores, aKnownErrorGivesTheKnownPsnr) {
    Picture p;
    for (size_t i = 0; i < p.rgb.size(); ++i)
        if (p.alpha[i / 3] > 0) p.rgb[i] += 0.1f;
    const ImageScores s = p.score();
    EXPECT_NEAR(s.worst.psnrMasked, 20, 1e-3);
    EXPECT_NEAR(s.worst.psnrFull, 20 + 10 * std::log10(3), 1e-3) << "two thirds of the picture is right for nothing";
}

TEST(ImageScores, aHoleIsPunishedOnSomeBackground) {
    Picture p;
    const size_t at = 10 * 40 + 20;
    p.alpha[at] = 0, p.rgb[at * 3] = p.rgb[at * 3 + 1] = p.rgb[at * 3 + 2] = 0;
    const ImageScores s = p.score();
    EXPECT_LT(s.worst.psnrMasked, s.grey.psnrMasked) << "a hole over grey hides behind a grey shirt; over white or black it shows";
    EXPECT_LT(s.alphaIou, 1);
}

}  // namespace
}  // namespace dpl
