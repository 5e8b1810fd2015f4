// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/keypoint_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace dpl {
namespace {

constexpr double kOutlierSigmas = 4;

std::vector<Vec2d> normalNoise(uint32_t seed, size_t count, double sigma) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, sigma);
    std::vector<Vec2d> residuals(count);
    for (Vec2d& r : residuals) r = {normal(random), normal(random)};
    return residuals;
}

TEST(KeypointNoise, findsTheSigmaOfNormalNoise) {
    for (uint32_t seed = 1; seed <= 20; ++seed)
        for (const double sigma : {1e-4, 0.0024, 0.02, 3.0}) {
            const auto noise = estimateKeypointNoise(normalNoise(seed, 1500, sigma), 0, kOutlierSigmas);
            ASSERT_TRUE(noise);
            EXPECT_NEAR(noise->sigma / sigma, 1, 0.09) << "seed " << seed;  // standard error with 3000 coordinates: 2.1 %
            EXPECT_LT(noise->outlierShare, 0.004) << "seed " << seed;       // beyond 4 σ in the plane: 0.03 %
        }
}

TEST(KeypointNoise, countsOutliersAndGrowsOnlyByWhatTheirNumberExplains) {
    // Of n residuals with a share s far off, the median is the quantile 0.5 / (1 − s) of the others, however far off the outliers are.
    const std::pair<double, double> kCases[] = {{0.05, 1.06}, {0.2, 1.32}, {0.4, 2.05}};
    for (const auto& [share, growth] : kCases) {
        std::vector<Vec2d> residuals = normalNoise(7, 2000, 1.5);
        for (size_t i = 0; i < size_t(share * 2000); ++i) residuals[i] = {400.0 + double(i), -900};
        const auto noise = estimateKeypointNoise(residuals, 0, kOutlierSigmas);
        ASSERT_TRUE(noise);
        EXPECT_NEAR(noise->outlierShare, share, 0.01);
        EXPECT_NEAR(noise->sigma / 1.5, growth, 0.08 * growth) << "a share of " << share;
    }
}

TEST(KeypointNoise, ofEqualResidualsTheSigmaIsTheirSizeAndNoneIsAnOutlier) {
    const auto noise = estimateKeypointNoise(std::vector<Vec2d>(300, Vec2d(2, -2)), 0, kOutlierSigmas);
    ASSERT_TRUE(noise);
    EXPECT_DOUBLE_EQ(noise->sigma, 1.4826 * 2) << "a common shift is error too, so deviations are taken from zero";
    EXPECT_EQ(noise->outlierShare, 0);
}

TEST(KeypointNoise, correctsForFittedParameters) {
    // Subtracting the mean of every pair of residuals fits half as many parameters as there are coordinates.
    std::vector<Vec2d> residuals = normalNoise(3, 4000, 2);
    for (size_t i = 0; i < residuals.size(); i += 2) {
        const Vec2d mean = 0.5 * (residuals[i] + residuals[i + 1]);
        residuals[i] -= mean, residuals[i + 1] -= mean;
    }
    const auto noise = estimateKeypointNoise(residuals, 4000, kOutlierSigmas);
    ASSERT_TRUE(noise);
    EXPECT_NEAR(noise->sigma, 2, 0.08);
    EXPECT_FALSE(estimateKeypointNoise(residuals, 4001, kOutlierSigmas)) << "hardly any residual is left";
}

TEST(KeypointNoise, hasNoEstimateWithoutData) {
    EXPECT_FALSE(estimateKeypointNoise({}, 0, kOutlierSigmas));
    EXPECT_FALSE(estimateKeypointNoise(normalNoise(1, 99, 1), 0, kOutlierSigmas)) << "too few";
    EXPECT_TRUE(estimateKeypointNoise(normalNoise(1, 100, 1), 0, kOutlierSigmas));
    EXPECT_FALSE(estimateKeypointNoise(std::vector<Vec2d>(500, Vec2d(0)), 0, kOutlierSigmas)) << "a sigma of zero would divide by zero";
    std::vector<Vec2d> broken = normalNoise(1, 150, 1);
    for (size_t i = 0; i < 51; ++i) broken[i].x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(estimateKeypointNoise(broken, 0, kOutlierSigmas)) << "residuals that are not finite do not count";
}

}  // namespace
}  // namespace dpl
