// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/observe/pose_crop.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace dpl {
namespace {

/** OpenCV's matrix that maps pixel centres of a side² picture of the crop to pixel centres of the whole picture. */
cv::Matx23d cropMatrix(const PersonCrop& crop, double side) {
    const double k = crop.sidePx / side, c = k * std::cos(crop.angleRad), s = k * std::sin(crop.angleRad);
    const Vec2d origin = cropToPicture(crop, {0.5, 0.5}, side) - 0.5;
    return {c, -s, origin.x, s, c, origin.y};
}

}  // namespace

Vec2d cropToPicture(const PersonCrop& crop, const Vec2d& px, double side) {
    const Vec2d d = (px / side - 0.5) * crop.sidePx;
    const double c = std::cos(crop.angleRad), s = std::sin(crop.angleRad);
    return crop.centrePx + Vec2d(c * d.x - s * d.y, s * d.x + c * d.y);
}

std::vector<float> cropToTensor(const ImageRgb8& image, const PersonCrop& crop, int side, const std::array<float, 3>& mean,
                                const std::array<float, 3>& deviation) {
    cv::Mat cut, source(int(image.heightPx), int(image.widthPx), CV_8UC3, const_cast<uint8_t*>(image.pixels.data()));
    PersonCrop used = crop;
    if (const double shrink = double(side) / crop.sidePx;
        shrink < 0.5) {  // average first, because bilinear sampling alone would skip pixels
        cv::resize(source, source, {}, 2 * shrink, 2 * shrink, cv::INTER_AREA);
        used.centrePx *= Vec2d(double(source.cols) / image.widthPx, double(source.rows) / image.heightPx);
        used.sidePx *= double(source.cols) / image.widthPx;
    }
    cv::warpAffine(source, cut, cropMatrix(used, side), {side, side}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_CONSTANT);
    std::vector<float> chw(size_t(3) * side * side);
    for (int c = 0; c < 3; ++c)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                chw[(size_t(c) * side + y) * side + x] =
                    (float(cut.at<cv::Vec3b>(y, x)[c]) / 255.0f - mean[size_t(c)]) / deviation[size_t(c)];
    return chw;
}

void mirrorRows(std::vector<float>& planes, int side) {
    for (auto row = planes.begin(); row != planes.end(); row += side) std::reverse(row, row + side);
}

std::vector<Vec2d> anchorCentres(int side, const AnchorGrids& grids) {
    std::vector<Vec2d> centres;
    for (const auto& [cell, each] : grids)
        for (int y = 0; y < side / cell; ++y)
            for (int x = 0; x < side / cell; ++x)
                for (int k = 0; k < each; ++k) centres.push_back(double(cell) * Vec2d(x + 0.5, y + 0.5));
    return centres;
}

cv::Mat spreadCrop(const float* plane, int side, const PersonCrop& crop, uint32_t width, uint32_t height) {
    const cv::Mat small(side, side, CV_32F, const_cast<float*>(plane));
    cv::Mat big;
    cv::warpAffine(small, big, cropMatrix(crop, side), {int(width), int(height)}, cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar(0));
    return big;
}

}  // namespace dpl
