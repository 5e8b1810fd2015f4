// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/detail.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace dpl {
namespace {

constexpr double kSigmasPx[] = {1, 2, 4};
constexpr int kMarginPx = 4;
constexpr size_t kFewestPixels = 64;

/** Luma in [0, 1] over mid grey. */
cv::Mat lumaOf(std::span<const uint8_t> rgba, int width, int height) {
    cv::Mat luma(height, width, CV_32F);
    float* to = luma.ptr<float>();
    for (size_t i = 0; i < luma.total(); ++i) {
        const uint8_t* p = rgba.data() + i * 4;
        const float alpha = float(p[3]) / 255;
        to[i] = alpha * (0.2126f * float(p[0]) + 0.7152f * float(p[1]) + 0.0722f * float(p[2])) / 255 + 0.5f * (1 - alpha);
    }
    return luma;
}

/** Gaussian mean over the pixels inside only. */
cv::Mat blurredInside(const cv::Mat& luma, const cv::Mat& inside, double sigmaPx) {
    cv::Mat sum, weight;
    cv::GaussianBlur(luma.mul(inside), sum, {}, sigmaPx, sigmaPx, cv::BORDER_CONSTANT);
    cv::GaussianBlur(inside, weight, {}, sigmaPx, sigmaPx, cv::BORDER_CONSTANT);
    return sum / cv::max(weight, 1e-6);
}

/** Correlation coefficient over `pixels`. 0 when a is constant; nullopt when b is. */
std::optional<double> correlation(const cv::Mat& a, const cv::Mat& b, const std::vector<int>& pixels) {
    constexpr double kConstant = 1e-10;  // variance below which rounding is all there is
    const float *pa = a.ptr<float>(), *pb = b.ptr<float>();
    double meanA = 0, meanB = 0, varA = 0, varB = 0, both = 0;
    const double n = double(pixels.size());
    for (const int i : pixels) meanA += double(pa[i]) / n, meanB += double(pb[i]) / n;
    for (const int i : pixels) {
        const double da = double(pa[i]) - meanA, db = double(pb[i]) - meanB;
        varA += da * da / n, varB += db * db / n, both += da * db / n;
    }
    if (varB < kConstant) return std::nullopt;
    return varA < kConstant ? 0 : both / std::sqrt(varA * varB);
}

}  // namespace

std::optional<double> detailCorrelation(std::span<const uint8_t> rgba, std::span<const uint8_t> truthRgba, uint32_t widthPx,
                                        uint32_t heightPx, std::span<const uint8_t> chosen) {
    const size_t count = size_t(widthPx) * heightPx;
    if (count == 0 || rgba.size() != count * 4 || truthRgba.size() != count * 4 || (!chosen.empty() && chosen.size() != count))
        return std::nullopt;
    const int width = int(widthPx), height = int(heightPx);
    cv::Mat opaque(height, width, CV_8U), core;
    for (size_t i = 0; i < count; ++i) opaque.data[i] = truthRgba[i * 4 + 3] == 255 ? 1 : 0;
    const int side = 2 * kMarginPx + 1;
    cv::erode(opaque, core, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}), {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
    std::vector<int> pixels;
    for (size_t i = 0; i < count; ++i)
        if (core.data[i] && (chosen.empty() || chosen[i])) pixels.push_back(int(i));
    if (pixels.size() < kFewestPixels) return std::nullopt;

    cv::Mat inside;
    opaque.convertTo(inside, CV_32F);
    const cv::Mat drawn = lumaOf(rgba, width, height), truth = lumaOf(truthRgba, width, height);
    double sum = 0;
    for (size_t band = 0; band + 1 < std::size(kSigmasPx); ++band) {
        const auto between = [&](const cv::Mat& luma) -> cv::Mat {
            return blurredInside(luma, inside, kSigmasPx[band]) - blurredInside(luma, inside, kSigmasPx[band + 1]);
        };
        const auto r = correlation(between(drawn), between(truth), pixels);
        if (!r) return std::nullopt;
        sum += *r;
    }
    return sum / double(std::size(kSigmasPx) - 1);
}

}  // namespace dpl
