// SPDX-License-Identifier: Apache-2.0
// PSNR and SSIM (docs/reference/metrics.md). Private to reconstruction/judging/report.
#pragma once

#include <opencv2/core.hpp>

namespace dpl {

constexpr double kEqualPsnrDb = 100;  // stands for infinity: the score of equal pictures

/** −10 log10 of a mean squared error of values in [0, 1], at most kEqualPsnrDb. */
double psnrDb(double meanSquare);

/** SSIM per pixel, mean of the three channels, of pictures with three float channels in [0, 1]. Gaussian window 11 × 11, σ = 1.5;
 *  C1 = 0.01², C2 = 0.03², data range 1. The border is mirrored. */
cv::Mat ssimMap(const cv::Mat& a, const cv::Mat& b);

}  // namespace dpl
