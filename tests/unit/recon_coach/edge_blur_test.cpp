// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/edge_blur.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace dpl {
namespace {

constexpr int kWidth = 240, kHeight = 240;

/** Steps in many directions: discs of different greys. Blurred by a Gaussian, with noise of one level. */
ImageRgb8 discs(double sigmaPx) {
    cv::Mat grey(4 * kHeight, 4 * kWidth, CV_32F, cv::Scalar(90));
    cv::RNG random(7);
    for (int i = 0; i < 12; ++i)
        cv::circle(grey, {160 + 320 * (i % 3), 120 + 240 * (i / 3)}, 100, cv::Scalar(30 + random.uniform(0, 2) * 150), cv::FILLED,
                   cv::LINE_8);
    cv::Mat small, noise(kHeight, kWidth, CV_32F), rgb;
    cv::resize(grey, small, {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
    if (sigmaPx > 0) cv::GaussianBlur(small, small, {}, sigmaPx);
    random.fill(noise, cv::RNG::NORMAL, 0, 1);
    small += noise;
    small.convertTo(small, CV_8U);
    cv::cvtColor(small, rgb, cv::COLOR_GRAY2RGB);
    return {kWidth, kHeight, std::vector<uint8_t>(rgb.data, rgb.data + rgb.total() * 3)};
}

std::optional<float> blurOfDiscs(double sigmaPx) {
    std::vector<float> sigmas;
    for (const EdgeBlur& edge : edgeBlurs(discs(sigmaPx), {})) sigmas.push_back(edge.sigmaPx);
    return blurOf(std::move(sigmas));
}

TEST(EdgeBlur, growsWithTheBlurAndIsItsRadiusOnSteps) {
    float before = -1;
    for (const double sigma : {0.0, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0}) {
        const auto found = blurOfDiscs(sigma);
        ASSERT_TRUE(found) << sigma;
        EXPECT_GT(*found, before) << sigma;
        // Pixels and noise add 0.45 px; at 5 px neighbouring edges take 0.3 px away.
        EXPECT_NEAR(*found, std::hypot(sigma, 0.45), 0.4) << sigma;
        before = *found;
    }
}

TEST(EdgeBlur, looksInsideTheMaskOnly) {
    ImageRgb8 image = discs(3);
    for (int y = 0; y < kHeight; ++y)  // a sharp edge that is not the person's
        for (int x = 0; x < 40; ++x)
            for (int c = 0; c < 3; ++c) image.pixels[size_t((y * kWidth + x) * 3 + c)] = x < 20 ? 0 : 255;
    ImageGrey8 mask{kWidth, kHeight, std::vector<uint8_t>(kWidth * kHeight, 0)};
    for (int y = 0; y < kHeight; ++y)
        for (int x = 50; x < kWidth; ++x) mask.pixels[size_t(y * kWidth + x)] = 255;
    const auto edges = edgeBlurs(image, mask);
    ASSERT_FALSE(edges.empty());
    for (const EdgeBlur& edge : edges) EXPECT_GE(edge.x, 54u);
}

TEST(EdgeBlur, aPlainPictureTellsNothing) {
    const ImageRgb8 plain{kWidth, kHeight, std::vector<uint8_t>(kWidth * kHeight * 3, 128)};
    std::vector<float> sigmas;
    for (const EdgeBlur& edge : edgeBlurs(plain, {})) sigmas.push_back(edge.sigmaPx);
    EXPECT_FALSE(blurOf(sigmas));
    EXPECT_TRUE(edgeBlurs({}, {}).empty());
}

}  // namespace
}  // namespace dpl
