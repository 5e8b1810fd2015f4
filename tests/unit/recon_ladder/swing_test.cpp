// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/swing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dpl {
namespace {

/** Three parts that swing at 1.1 Hz about places of their own, in different directions. */
std::vector<SwingSample> swinging(double fromS, double toS, double rate, double amplitudeM, double lateS) {
    std::vector<SwingSample> samples;
    for (int k = 0; fromS + k / rate <= toS + 1e-9; ++k) {
        const double timeS = fromS + k / rate;
        SwingSample sample{timeS, {}};
        for (int p = 0; p < 3; ++p)
            sample.parts.push_back(Vec2d(0.1 * p, -0.2) +
                                   amplitudeM * std::sin(6.283185 * 1.1 * (timeS - lateS)) * Vec2d(std::cos(2.0 * p), std::sin(2.0 * p)));
        samples.push_back(std::move(sample));
    }
    return samples;
}

TEST(Swing, findsHowFarAndHowLate) {
    const auto truth = swinging(1, 2.25, 8, 0.05, 0);
    for (const double late : {-0.1, 0.0, 0.06, 0.15}) {
        const Swing swing = compareSwing(truth, swinging(0.5, 2.7, 24, 0.03, late), 0.3);
        EXPECT_NEAR(swing.lateS, late, 0.011) << "two steps of the shift, and straight lines between pictures";
        EXPECT_NEAR(swing.amplitude, 0.6, 0.02) << late;
        EXPECT_GT(swing.correlation, 0.99) << late;
        EXPECT_NEAR(swing.trueRmsM, 0.05 / std::sqrt(2), 0.004);
    }
}

TEST(Swing, aHemThatHangsStillHasNoAmplitudeWhereverItHangs) {
    const auto truth = swinging(1, 2.25, 8, 0.05, 0);
    auto still = swinging(0.5, 2.7, 24, 0, 0);
    for (SwingSample& sample : still)
        for (Vec2d& part : sample.parts) part += Vec2d(1, 2);
    const Swing swing = compareSwing(truth, still, 0.3);
    EXPECT_NEAR(swing.amplitude, 0, 1e-9);
    EXPECT_LT(swing.correlation, 0.1);
    EXPECT_GT(swing.trueRmsM, 0.03);
}

TEST(Swing, whatCannotBeComparedIsZero) {
    const auto truth = swinging(1, 2.25, 8, 0.05, 0);
    EXPECT_EQ(compareSwing(truth, {}, 0.3).times, 0u);
    EXPECT_EQ(compareSwing({}, swinging(0, 3, 24, 0.05, 0), 0.3).times, 0u);
    EXPECT_EQ(compareSwing(truth, swinging(0, 1.4, 24, 0.05, 0), 0.3).times, 0u) << "too little of it in common";
    EXPECT_EQ(compareSwing(swinging(1, 2.25, 8, 0, 0), swinging(0.5, 2.7, 24, 0.05, 0), 0.3).times, 0u) << "nothing swings";
}

}  // namespace
}  // namespace dpl
