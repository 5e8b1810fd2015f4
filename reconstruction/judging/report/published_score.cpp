// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/published_score.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/judging/report/picture_error.h"
#include "reconstruction/judging/report/score.h"

namespace dpl {
namespace {

constexpr int kBorderPx = 5;  // half the window of SSIM; the library that the papers used cuts it off

/** Eight-bit RGB over white outside the mask, as three channels in [0, 1]. */
cv::Mat maskedOverWhite(const uint8_t* rgb, const ImageGrey8& mask) {
    cv::Mat out(int(mask.heightPx), int(mask.widthPx), CV_32FC3);
    float* to = out.ptr<float>();
    for (size_t i = 0; i < mask.pixels.size(); ++i) {
        const float person = float(mask.pixels[i]) / 255.0f;
        for (size_t c = 0; c < 3; ++c) to[3 * i + c] = float(rgb[3 * i + c]) / 255.0f * person + (1 - person);
    }
    return out;
}

double meanSsim(const cv::Mat& a, const cv::Mat& b) {
    cv::Mat all = ssimMap(a, b);
    const cv::Rect inside(kBorderPx, kBorderPx, all.cols - 2 * kBorderPx, all.rows - 2 * kBorderPx);
    return cv::mean(all(inside))[0];
}

}  // namespace

Result<PublishedScore> scoreAsPublished(std::span<const uint8_t> rgba, const ImageRgb8& truth, const ImageGrey8& mask, const Lpips* lpips) {
    const size_t pixels = size_t(truth.widthPx) * truth.heightPx;
    if (rgba.size() != 4 * pixels || truth.pixels.size() != 3 * pixels || mask.pixels.size() != pixels || mask.widthPx != truth.widthPx)
        return fail(Code::InvalidArgument, "picture, frame and mask have different sizes");
    if (truth.widthPx <= 2 * kBorderPx || truth.heightPx <= 2 * kBorderPx)
        return fail(Code::InvalidArgument, "a picture of {} x {} pixels is too small for SSIM", truth.widthPx, truth.heightPx);
    const std::vector<uint8_t> shown = overWhite({rgba.begin(), rgba.end()});
    const cv::Mat a = maskedOverWhite(shown.data(), mask), b = maskedOverWhite(truth.pixels.data(), mask);
    PublishedScore score;
    double squares = 0;
    const float *x = a.ptr<float>(), *y = b.ptr<float>();
    for (size_t i = 0; i < 3 * pixels; ++i) squares += (double(x[i]) - y[i]) * (double(x[i]) - y[i]);
    score.psnrDb = psnrDb(squares / (3.0 * double(pixels)));
    score.ssim = meanSsim(a, b);
    if (lpips) {
        const auto planes = [&](const float* rgb) {
            std::vector<float> out(3 * pixels);
            for (size_t i = 0; i < pixels; ++i)
                for (size_t c = 0; c < 3; ++c) out[c * pixels + i] = 2 * rgb[3 * i + c] - 1;
            return out;
        };
        DPL_TRY(score.lpips, lpips->distance(planes(x), planes(y), truth.widthPx, truth.heightPx));
    }
    return score;
}

std::optional<PublishedScore> meanOf(std::span<const PublishedScore> scores) {
    if (scores.empty()) return std::nullopt;
    PublishedScore mean;
    mean.lpips = 0.0;
    for (const PublishedScore& score : scores) {
        mean.psnrDb += score.psnrDb / double(scores.size()), mean.ssim += score.ssim / double(scores.size());
        if (mean.lpips && score.lpips)
            *mean.lpips += *score.lpips / double(scores.size());
        else
            mean.lpips.reset();
    }
    return mean;
}

}  // namespace dpl
