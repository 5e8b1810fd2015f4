// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/frame_features.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace dpl {
namespace {

constexpr double kWideBlur = 3;        // width of the blur that is subtracted, in blurs
constexpr float kMinCoverage = 0.02f;  // lets the continuation outside the mask fade

/** Blur of `image` that only sees pixels of `mask`; `coverage` is the blurred mask. */
cv::Mat blurInside(const cv::Mat& image, const cv::Mat& mask, double sigma) {
    cv::Mat sum, coverage, out;
    cv::GaussianBlur(image, sum, cv::Size(), sigma, sigma, cv::BORDER_CONSTANT);
    cv::GaussianBlur(mask, coverage, cv::Size(), sigma, sigma, cv::BORDER_CONSTANT);
    cv::max(coverage, kMinCoverage, coverage);
    cv::Mat three;
    cv::merge(std::vector<cv::Mat>{coverage, coverage, coverage}, three);
    cv::divide(sum, three, out);
    return out;
}

}  // namespace

FramePicture reducedPicture(const FramePicture& picture, uint32_t maxSidePx) {
    const uint32_t side = std::max(picture.image.widthPx, picture.image.heightPx);
    if (side <= maxSidePx) return picture;
    const auto size = [&](uint32_t px) { return std::max(1u, uint32_t(double(px) * maxSidePx / side + 0.5)); };
    const uint32_t width = size(picture.image.widthPx), height = size(picture.image.heightPx);
    const auto reduce = [&](const auto& from, int type, int how, auto& to) {
        if (from.pixels.empty()) return;
        to.widthPx = width, to.heightPx = height;
        to.pixels.resize(size_t(width) * height * size_t(CV_MAT_CN(type)));
        cv::Mat out(int(height), int(width), type, to.pixels.data());
        cv::resize(cv::Mat(int(from.heightPx), int(from.widthPx), type, const_cast<uint8_t*>(from.pixels.data())), out, out.size(), 0, 0,
                   how);
    };
    FramePicture reduced;
    reduce(picture.image, CV_8UC3, cv::INTER_AREA, reduced.image);
    reduce(picture.mask, CV_8UC1, cv::INTER_AREA, reduced.mask);
    reduce(picture.labels, CV_8UC1, cv::INTER_NEAREST, reduced.labels);
    return reduced;
}

bool ContrastImage::sample(const Vec2d& px, Vec3d& value, Vec3d& dx, Vec3d& dy) const {
    const double x = px.x - 0.5, y = px.y - 0.5;
    if (!(x >= 0 && y >= 0 && x < widthPx - 1.0 && y < heightPx - 1.0)) return false;
    const size_t ix = size_t(x), iy = size_t(y), at = iy * widthPx + ix;
    const double fx = x - double(ix), fy = y - double(iy);
    const Vec3d a(values[at]), b(values[at + 1]), c(values[at + widthPx]), d(values[at + widthPx + 1]);
    dx = (1 - fy) * (b - a) + fy * (d - c);
    dy = (1 - fx) * (c - a) + fx * (d - b);
    value = (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d);
    return true;
}

ContrastImage contrastImage(const FramePicture& picture, double blurPx) {
    const int width = int(picture.image.widthPx), height = int(picture.image.heightPx);
    const cv::Mat rgb(height, width, CV_8UC3, const_cast<uint8_t*>(picture.image.pixels.data()));
    const cv::Mat soft(height, width, CV_8UC1, const_cast<uint8_t*>(picture.mask.pixels.data()));
    cv::Mat mask, colour, three;
    cv::Mat(soft >= 128).convertTo(mask, CV_32F, 1 / 255.0);
    rgb.convertTo(colour, CV_32FC3, 1 / 255.0);
    cv::merge(std::vector<cv::Mat>{mask, mask, mask}, three);
    cv::multiply(colour, three, colour);
    cv::Mat contrast = blurInside(colour, mask, blurPx) - blurInside(colour, mask, kWideBlur * blurPx);
    ContrastImage out{picture.image.widthPx, picture.image.heightPx, {}, {}};
    const auto* first = contrast.ptr<Vec3f>();
    out.values.assign(first, first + size_t(width) * size_t(height));
    cv::Mat inside = soft >= 128;
    out.inside.assign(inside.data, inside.data + size_t(width) * size_t(height));
    return out;
}

FrameOutlines frameOutlines(const FramePicture& picture, std::span<const uint8_t> labels, uint32_t maxSidePx) {
    FrameOutlines outlines;
    if (auto person = maskDistance(picture.mask, maxSidePx)) outlines.byLabel.emplace(uint8_t(0), std::move(*person));
    if (picture.labels.pixels.empty()) return outlines;
    ImageGrey8 region{picture.labels.widthPx, picture.labels.heightPx, {}};
    for (const uint8_t label : labels) {
        region.pixels.resize(picture.labels.pixels.size());
        std::transform(picture.labels.pixels.begin(), picture.labels.pixels.end(), region.pixels.begin(),
                       [&](uint8_t value) { return uint8_t(value == label ? 255 : 0); });
        if (auto distance = maskDistance(region, maxSidePx)) outlines.byLabel.emplace(label, std::move(*distance));
    }
    return outlines;
}

}  // namespace dpl
