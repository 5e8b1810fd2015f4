// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/observe/refine_matte.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace dpl {
namespace {

constexpr double kEpsilon = 1e-4;  // of the variance of a colour in a window, colours in 0 … 1: below it, edges are noise
constexpr double kCertain = 0.1;   // the filter's result is stretched so that what lies this near to 0 or 1 becomes 0 or 1

cv::Mat mean(const cv::Mat& plane, int radius) {
    cv::Mat out;
    cv::blur(plane, out, {2 * radius + 1, 2 * radius + 1}, {-1, -1}, cv::BORDER_REFLECT);
    return out;
}

/** Guided filter (He, Sun and Tang 2013) of `input` with a colour guide: in each window the output is the affine function of the colour
 * that fits the input best; a pixel gets the mean over its windows. */
cv::Mat guidedFilter(const cv::Mat guide[3], const cv::Mat& input, int radius) {
    cv::Mat means[3], covariance[3][3], cross[3];
    const cv::Mat inputMean = mean(input, radius);
    for (int i = 0; i < 3; ++i) {
        means[i] = mean(guide[i], radius);
        cross[i] = mean(guide[i].mul(input), radius) - means[i].mul(inputMean);
    }
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) covariance[i][j] = mean(guide[i].mul(guide[j]), radius) - mean(guide[i], radius).mul(means[j]);
    cv::Mat a[3], b(input.size(), CV_64F);
    for (cv::Mat& plane : a) plane = cv::Mat(input.size(), CV_64F);
    for (int y = 0; y < input.rows; ++y)
        for (int x = 0; x < input.cols; ++x) {
            Mat3d sigma(0.0);
            Vec3d c(0), m(0);
            for (int i = 0; i < 3; ++i) {
                c[i] = cross[i].at<double>(y, x), m[i] = means[i].at<double>(y, x);
                for (int j = i; j < 3; ++j) sigma[i][j] = sigma[j][i] = covariance[i][j].at<double>(y, x);
                sigma[i][i] += kEpsilon;
            }
            const Vec3d slope = glm::inverse(sigma) * c;
            for (int i = 0; i < 3; ++i) a[i].at<double>(y, x) = slope[i];
            b.at<double>(y, x) = inputMean.at<double>(y, x) - glm::dot(slope, m);
        }
    cv::Mat out = mean(b, radius);
    for (int i = 0; i < 3; ++i) out += mean(a[i], radius).mul(guide[i]);
    return out;
}

}  // namespace

ImageGrey8 refineMatte(const ImageRgb8& image, const ImageGrey8& mask, int bandPx) {
    ImageGrey8 out{mask.widthPx, mask.heightPx, std::vector<uint8_t>(mask.pixels.size(), 0)};
    if (image.widthPx != mask.widthPx || image.heightPx != mask.heightPx || mask.pixels.empty() || bandPx < 1) return mask;
    const cv::Mat soft(int(mask.heightPx), int(mask.widthPx), CV_8U, const_cast<uint8_t*>(mask.pixels.data()));
    const cv::Mat hard = soft >= 128;
    const cv::Mat ball = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * bandPx + 1, 2 * bandPx + 1});
    cv::Mat inside, outside, input, guide[3];
    cv::erode(hard, inside, ball), cv::dilate(hard, outside, ball);
    hard.convertTo(input, CV_64F, 1 / 255.0);
    const cv::Mat rgb(int(image.heightPx), int(image.widthPx), CV_8UC3, const_cast<uint8_t*>(image.pixels.data()));
    for (int c = 0; c < 3; ++c) {
        cv::extractChannel(rgb, guide[c], c);
        guide[c].convertTo(guide[c], CV_64F, 1 / 255.0);
    }
    const cv::Mat filtered = guidedFilter(guide, input, bandPx);
    for (int y = 0; y < soft.rows; ++y)
        for (int x = 0; x < soft.cols; ++x) {
            uint8_t& value = out.pixels[size_t(y) * mask.widthPx + size_t(x)];
            if (inside.at<uint8_t>(y, x))
                value = 255;
            else if (outside.at<uint8_t>(y, x))
                value = uint8_t(std::lround(255 * std::clamp((filtered.at<double>(y, x) - kCertain) / (1 - 2 * kCertain), 0.0, 1.0)));
        }
    return out;
}

}  // namespace dpl
