// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/features.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace dpl {
namespace {

constexpr double kRatio = 0.8;  // Lowe's: the best match must be this much nearer than the second
// OpenCV's SIFT first doubles the picture, which moves pixel u to 2u + 0.5, and then halves positions without taking that back.
constexpr double kDoublingShiftPx = 0.25;

bool fits(const GreyView& view) {
    return view.widthPx > 0 && view.heightPx > 0 && view.pixels.size() == size_t(view.widthPx) * view.heightPx;
}

cv::Mat asMat(const GreyView& view) {
    return {int(view.heightPx), int(view.widthPx), CV_8UC1, const_cast<uint8_t*>(view.pixels.data())};
}

/** One descriptor a column. */
Eigen::MatrixXf asColumns(const Features& features) {
    using Bytes = Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic>;
    return Eigen::Map<const Bytes>(features.descriptors.data(), kFeatureBytes, Eigen::Index(features.size())).cast<float>();
}

/** For each column of `squared` the row of its least value if that is clearly less than the next, else −1. */
std::vector<Eigen::Index> clearlyLeast(const Eigen::MatrixXf& squared) {
    std::vector<Eigen::Index> least(size_t(squared.cols()), -1);
    for (Eigen::Index c = 0; c < squared.cols(); ++c) {
        Eigen::Index at = 0;
        float first = INFINITY, second = INFINITY;
        for (Eigen::Index r = 0; r < squared.rows(); ++r)
            if (const float value = squared(r, c); value < first)
                second = first, first = value, at = r;
            else if (value < second)
                second = value;
        if (first < kRatio * kRatio * second) least[size_t(c)] = at;
    }
    return least;
}

}  // namespace

Features findFeatures(const GreyView& picture, const GreyView& where, size_t most, uint32_t maxSidePx) {
    Features out;
    const bool masked = !where.pixels.empty();
    if (!fits(picture) || (masked && (!fits(where) || where.widthPx != picture.widthPx || where.heightPx != picture.heightPx))) return out;
    cv::Mat image = asMat(picture), mask = masked ? asMat(where) : cv::Mat();
    const double shrink = std::min(1.0, double(maxSidePx) / std::max(picture.widthPx, picture.heightPx));
    if (shrink < 1) {
        cv::resize(image, image, {}, shrink, shrink, cv::INTER_AREA);
        if (masked) cv::resize(mask, mask, image.size(), 0, 0, cv::INTER_NEAREST);
    }
    const auto sift = cv::SIFT::create(int(most), 3, 0.02, 10, 1.6, CV_8U);
    std::vector<cv::KeyPoint> points;
    cv::Mat descriptors;
    sift->detectAndCompute(image, mask, points, descriptors);
    const double scaleX = double(picture.widthPx) / image.cols, scaleY = double(picture.heightPx) / image.rows;
    const size_t count = std::min(points.size(), most);  // ties at the end of the list may exceed it
    for (size_t i = 0; i < count; ++i)
        out.px.emplace_back((points[i].pt.x - kDoublingShiftPx + 0.5) * scaleX, (points[i].pt.y - kDoublingShiftPx + 0.5) * scaleY);
    if (count > 0) out.descriptors.assign(descriptors.ptr(), descriptors.ptr() + count * kFeatureBytes);
    return out;
}

std::vector<FeatureMatch> matchFeatures(const Features& a, const Features& b) {
    std::vector<FeatureMatch> matches;
    if (a.size() < 2 || b.size() < 2) return matches;
    // ‖x − y‖² = ‖x‖² + ‖y‖² − 2 x·y. The products of whole bytes are exact in float: below 2²⁴.
    const Eigen::MatrixXf x = asColumns(a), y = asColumns(b);
    Eigen::MatrixXf squared = -2 * (x.transpose() * y);
    squared.colwise() += x.colwise().squaredNorm().transpose();
    squared.rowwise() += y.colwise().squaredNorm();
    const auto back = clearlyLeast(squared), there = clearlyLeast(squared.transpose());
    for (size_t i = 0; i < there.size(); ++i)
        if (there[i] >= 0 && back[size_t(there[i])] == Eigen::Index(i)) matches.push_back({uint32_t(i), uint32_t(there[i])});
    return matches;
}

std::vector<Vec2d> pinholePixels(std::span<const Vec2d> stored, const Camerad& camera, const LensDistortion& lens) {
    std::vector<Vec2d> out;
    for (const Vec2d& px : stored) {
        const double dx = (px.x - camera.cx) / camera.fx, dy = (px.y - camera.cy) / camera.fy;
        double x = dx, y = dy;
        for (int round = 0; round < 20 && lens.any(); ++round) {  // fixed point; checkDistortion() makes sure that it converges
            const double r2 = x * x + y * y, scale = 1 + lens.k1 * r2 + lens.k2 * r2 * r2;
            x = dx / scale, y = dy / scale;
        }
        out.emplace_back(camera.fx * x + camera.cx, camera.fy * y + camera.cy);
    }
    return out;
}

}  // namespace dpl
