// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/label_score.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "reconstruction/judging/report/picture_error.h"

namespace dpl {
namespace {

/** 1 for the pixels whose nearest pixel of the person shows the label. */
std::vector<uint8_t> nearestShows(const std::vector<uint8_t>& truthRgba, const ImageGrey8& labels, uint8_t label) {
    const int width = int(labels.widthPx), height = int(labels.heightPx);
    cv::Mat apart(height, width, CV_8U), distance, nearest;
    uint8_t* to = apart.ptr<uint8_t>();
    for (size_t i = 0; i < labels.pixels.size(); ++i) to[i] = truthRgba[i * 4 + 3] >= 128 ? 0 : 1;
    cv::distanceTransform(apart, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
    const int* source = nearest.ptr<int>();
    std::vector<uint8_t> shows(labels.pixels.size() + 1, 0);  // by the number that the transform gives a pixel of the person
    for (size_t i = 0; i < labels.pixels.size(); ++i)
        if (to[i] == 0) shows[size_t(source[i])] = labels.pixels[i] == label;
    std::vector<uint8_t> near(labels.pixels.size());
    for (size_t i = 0; i < near.size(); ++i) near[i] = shows[size_t(source[i])];
    return near;
}

/** Of the pixels that count, the mean square of the difference of two pictures on a background, over three channels in [0, 1]. */
double meanSquareOn(double background, const std::vector<uint8_t>& a, const std::vector<uint8_t>& b, const std::vector<uint8_t>& counts) {
    double squares = 0;
    size_t count = 0;
    const auto shown = [&](const std::vector<uint8_t>& rgba, size_t i, int c) {
        const double alpha = rgba[i * 4 + 3] / 255.0;
        return rgba[i * 4 + size_t(c)] / 255.0 * alpha + background * (1 - alpha);
    };
    for (size_t i = 0; i < counts.size(); ++i) {
        if (counts[i] == 0) continue;
        ++count;
        for (int c = 0; c < 3; ++c) squares += (shown(a, i, c) - shown(b, i, c)) * (shown(a, i, c) - shown(b, i, c));
    }
    return squares / (3.0 * double(count));
}

}  // namespace

std::optional<LabelScore> scoreLabel(const std::vector<uint8_t>& rgba, const std::vector<uint8_t>& truthRgba, const ImageGrey8& labels,
                                     uint8_t label) {
    const size_t pixels = size_t(labels.widthPx) * labels.heightPx;
    if (rgba.size() != 4 * pixels || truthRgba.size() != 4 * pixels || labels.pixels.size() != pixels) return std::nullopt;
    std::vector<uint8_t> of(pixels);
    for (size_t i = 0; i < pixels; ++i) of[i] = truthRgba[i * 4 + 3] >= 128 && labels.pixels[i] == label;
    if (size_t(std::count(of.begin(), of.end(), uint8_t(1))) < kLeastLabelPixels) return std::nullopt;
    LabelScore score{kEqualPsnrDb, 0};
    for (const double background : {1.0, 0.0, 0.5})
        score.maskedPsnrDb = std::min(score.maskedPsnrDb, psnrDb(meanSquareOn(background, rgba, truthRgba, of)));
    const std::vector<uint8_t> near = nearestShows(truthRgba, labels, label);
    size_t both = 0, either = 0;
    for (size_t i = 0; i < pixels; ++i) {
        if (near[i] == 0) continue;
        const bool person = truthRgba[i * 4 + 3] >= 128, drawn = rgba[i * 4 + 3] >= 128;
        both += person && drawn, either += person || drawn;
    }
    score.outlineIou = double(both) / double(either);
    return score;
}

}  // namespace dpl
