// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/light.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "reconstruction/input/capture/frame_picture.h"

namespace dpl {
namespace {

uint8_t times(uint8_t value, double factor) {
    return uint8_t(std::clamp(double(value) * factor + 0.5, 0.0, 255.0));
}

bool counts(const std::vector<uint8_t>& rgba, const ImageGrey8& mask, size_t i) {
    return isPerson(mask.pixels[i]) && rgba[4 * i + 3] >= 128;
}

}  // namespace

std::vector<uint8_t> withBestGain(const std::vector<uint8_t>& rgba, const ImageRgb8& truth, const ImageGrey8& mask) {
    double drawnTrue[3] = {}, drawnDrawn[3] = {};
    for (size_t i = 0; i < mask.pixels.size(); ++i)
        for (size_t c = 0; c < 3 && counts(rgba, mask, i); ++c) {
            const double d = rgba[4 * i + c];
            drawnTrue[c] += d * truth.pixels[3 * i + c], drawnDrawn[c] += d * d;
        }
    std::vector<uint8_t> out = rgba;
    for (size_t i = 0; i < mask.pixels.size(); ++i)
        for (size_t c = 0; c < 3; ++c)
            if (drawnDrawn[c] > 0) out[4 * i + c] = times(rgba[4 * i + c], drawnTrue[c] / drawnDrawn[c]);
    return out;
}

std::vector<uint8_t> withBestLight(const std::vector<uint8_t>& rgba, const ImageRgb8& truth, const ImageGrey8& mask, double window) {
    const int width = int(truth.widthPx), height = int(truth.heightPx);
    cv::Mat drawnTrue(height, width, CV_32F, cv::Scalar(0)), drawnDrawn(height, width, CV_32F, cv::Scalar(0));
    float *a = drawnTrue.ptr<float>(), *b = drawnDrawn.ptr<float>();
    for (size_t i = 0; i < mask.pixels.size(); ++i)
        for (size_t c = 0; c < 3 && counts(rgba, mask, i); ++c) {
            const float d = rgba[4 * i + c];
            a[i] += d * float(truth.pixels[3 * i + c]), b[i] += d * d;
        }
    const double sigma = window * height;
    cv::GaussianBlur(drawnTrue, drawnTrue, cv::Size(), sigma, sigma, cv::BORDER_CONSTANT);
    cv::GaussianBlur(drawnDrawn, drawnDrawn, cv::Size(), sigma, sigma, cv::BORDER_CONSTANT);
    a = drawnTrue.ptr<float>(), b = drawnDrawn.ptr<float>();
    std::vector<uint8_t> out = rgba;
    for (size_t i = 0; i < mask.pixels.size(); ++i)
        for (size_t c = 0; c < 3 && b[i] > 1; ++c) out[4 * i + c] = times(rgba[4 * i + c], double(a[i]) / double(b[i]));
    return out;
}

}  // namespace dpl
