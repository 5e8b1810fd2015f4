// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/edge_blur.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr double kFinePx = 0.8, kCoarsePx = 2.0;  // standard deviations of the two blurs that are compared
constexpr double kDifferencePx2 = 1.0 / 3;        // variance of the central difference, a box 2 px wide
constexpr float kLeastGradient = 4;               // grey levels a pixel; sensor noise of 1 level stays below 1 after the finer blur
constexpr int kOutlinePx = 4;
constexpr float kLargestPx = 8;  // wider edges are shading rather than blur
constexpr size_t kFewestEdges = 40;

/** Half the difference of the neighbours, both ways. */
struct Gradient {
    cv::Mat x, y;
    Gradient(const cv::Mat& grey, double sigmaPx) {
        cv::Mat soft;
        cv::GaussianBlur(grey, soft, {}, sigmaPx, sigmaPx, cv::BORDER_REPLICATE);
        const cv::Mat across = (cv::Mat_<float>(1, 3) << -0.5f, 0, 0.5f);
        cv::filter2D(soft, x, CV_32F, across, {-1, -1}, 0, cv::BORDER_REPLICATE);
        cv::filter2D(soft, y, CV_32F, across.t(), {-1, -1}, 0, cv::BORDER_REPLICATE);
    }
    float at(int row, int column) const { return std::hypot(x.at<float>(row, column), y.at<float>(row, column)); }
};

/** Whether the gradient is largest here along its own direction, rounded to the eight neighbours. */
bool isRidge(const Gradient& g, int row, int column, float here) {
    const float gx = g.x.at<float>(row, column), gy = g.y.at<float>(row, column);
    const int dx = std::abs(gx) > 0.4f * std::abs(gy) ? (gx > 0 ? 1 : -1) : 0,
              dy = std::abs(gy) > 0.4f * std::abs(gx) ? (gy > 0 ? 1 : -1) : 0;
    return here >= g.at(row + dy, column + dx) && here > g.at(row - dy, column - dx);
}

}  // namespace

std::vector<EdgeBlur> edgeBlurs(const ImageRgb8& image, const ImageGrey8& mask) {
    const int width = int(image.widthPx), height = int(image.heightPx);
    std::vector<EdgeBlur> edges;
    if (width < 3 || height < 3 || image.pixels.size() != size_t(width) * size_t(height) * 3) return edges;
    cv::Mat where(height, width, CV_8U, cv::Scalar(255));
    if (!mask.pixels.empty()) {
        if (mask.widthPx != image.widthPx || mask.heightPx != image.heightPx) return edges;
        const cv::Mat soft(height, width, CV_8U, const_cast<uint8_t*>(mask.pixels.data()));
        const int side = 2 * kOutlinePx + 1;
        cv::erode(soft >= 128, where, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}), {-1, -1}, 1, cv::BORDER_CONSTANT,
                  cv::Scalar(0));
    }
    cv::Rect box = cv::boundingRect(where);
    if (box.empty()) return edges;
    const int margin = int(std::ceil(4 * kCoarsePx));  // what the blurs reach
    box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) & cv::Rect(0, 0, width, height);
    const cv::Mat rgb(height, width, CV_8UC3, const_cast<uint8_t*>(image.pixels.data()));
    cv::Mat grey8, grey;
    cv::cvtColor(rgb(box), grey8, cv::COLOR_RGB2GRAY);
    grey8.convertTo(grey, CV_32F);
    const Gradient fine(grey, kFinePx), coarse(grey, kCoarsePx);
    // A step blurred by σ has the gradient c/√(σ² + s²) after a further blur of s. Two values of s give σ.
    constexpr double kFine2 = kFinePx * kFinePx, kCoarse2 = kCoarsePx * kCoarsePx;
    for (int y = 1; y + 1 < box.height; ++y)
        for (int x = 1; x + 1 < box.width; ++x) {
            if (!where.at<uint8_t>(box.y + y, box.x + x)) continue;
            const float here = fine.at(y, x);
            if (here < kLeastGradient || !isRidge(fine, y, x, here)) continue;
            const double ratio = double(here) / std::max(1e-6f, coarse.at(y, x)), squared = ratio * ratio;
            double variance = double(kLargestPx * kLargestPx);
            if (squared > 1.001) variance = (kCoarse2 - kFine2 * squared) / (squared - 1) - kDifferencePx2;
            const float sigma = float(std::sqrt(std::clamp(variance, 0.0, double(kLargestPx * kLargestPx))));
            edges.push_back({uint32_t(box.x + x), uint32_t(box.y + y), sigma});
        }
    return edges;
}

std::optional<float> blurOf(std::vector<float> sigmasPx) {
    if (sigmasPx.size() < kFewestEdges) return std::nullopt;
    return percentile(std::move(sigmasPx), 0.75);
}

}  // namespace dpl
