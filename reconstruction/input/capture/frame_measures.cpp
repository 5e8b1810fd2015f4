// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/frame_measures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace dpl {
namespace {

/** Share of the neighbour differences inside `where` that remains after a 9-tap box blur; the larger of both directions (Crete et al.
 * 2007).
 */
double blurIndexOf(const cv::Mat& grey, const cv::Mat& where) {
    double worst = 0;
    for (const bool horizontal : {true, false}) {
        cv::Mat blurred;
        cv::blur(grey, blurred, horizontal ? cv::Size(9, 1) : cv::Size(1, 9));
        double before = 0, lost = 0;
        const int dx = horizontal ? 1 : 0, dy = horizontal ? 0 : 1;
        for (int y = dy; y < grey.rows; ++y)
            for (int x = dx; x < grey.cols; ++x) {
                if (!where.at<uint8_t>(y, x)) continue;
                const double d = std::abs(double(grey.at<float>(y, x)) - grey.at<float>(y - dy, x - dx));
                const double b = std::abs(double(blurred.at<float>(y, x)) - blurred.at<float>(y - dy, x - dx));
                before += d;
                lost += std::max(0.0, d - b);
            }
        if (before > 0) worst = std::max(worst, (before - lost) / before);
    }
    return worst;
}

void measureImage(const ImageRgb8& image, const ImageGrey8& mask, FrameCheck& check) {
    const cv::Mat rgb(int(image.heightPx), int(image.widthPx), CV_8UC3, const_cast<uint8_t*>(image.pixels.data()));
    cv::Mat grey8, grey, laplacian, where;
    cv::cvtColor(rgb, grey8, cv::COLOR_RGB2GRAY);
    grey8.convertTo(grey, CV_32F);
    if (mask.pixels.empty()) {
        where = cv::Mat(grey.size(), CV_8U, cv::Scalar(255));
    } else {
        const cv::Mat soft(int(mask.heightPx), int(mask.widthPx), CV_8U, const_cast<uint8_t*>(mask.pixels.data()));
        // Measure inside the mask only: the outline can be sharp where the person is blurred, and the reverse.
        cv::erode(soft >= 128, where, cv::getStructuringElement(cv::MORPH_ELLIPSE, {7, 7}));
    }
    if (cv::countNonZero(where) < 64) return;
    cv::Laplacian(grey, laplacian, CV_32F, 1);
    cv::Scalar mean, deviation;
    cv::meanStdDev(laplacian, mean, deviation, where);
    check.sharpness = deviation[0] * deviation[0];
    check.brightness = cv::mean(grey, where)[0];
    check.blurIndex = blurIndexOf(grey, where);
}

void measureMask(const ImageGrey8& mask, FrameCheck& check) {
    const uint32_t w = mask.widthPx, h = mask.heightPx;
    size_t person = 0, border = 0;
    for (uint32_t y = 0; y < h; ++y)
        for (uint32_t x = 0; x < w; ++x) {
            if (mask.pixels[size_t(y) * w + x] < 128) continue;
            ++person;
            border += x == 0 || y == 0 || x + 1 == w || y + 1 == h;
        }
    check.maskShare = double(person) / (double(w) * h);
    check.borderShare = double(border) / (2.0 * (w + h));
}

/** Share of confident keypoints that lie on the mask, within 3 % of the picture's height of it. */
double keypointsOnMask(const std::vector<Keypoint>& keypoints, const ImageGrey8& mask) {
    const cv::Mat soft(int(mask.heightPx), int(mask.widthPx), CV_8U, const_cast<uint8_t*>(mask.pixels.data()));
    cv::Mat near;
    const int reach = 2 * int(std::ceil(0.03 * mask.heightPx)) + 1;
    cv::dilate(soft >= 128, near, cv::getStructuringElement(cv::MORPH_RECT, {reach, reach}));
    double confident = 0, on = 0;
    for (const Keypoint& k : keypoints) {
        if (k.confidence < 0.5 || k.px.x < 0 || k.px.y < 0 || k.px.x >= mask.widthPx || k.px.y >= mask.heightPx) continue;
        confident += 1;
        on += near.at<uint8_t>(int(k.px.y), int(k.px.x)) != 0;
    }
    return confident >= 4 ? on / confident : -1;
}

double labelIou(const ImageGrey8& labels, const ImageGrey8& mask) {
    size_t both = 0, either = 0;
    for (size_t i = 0; i < mask.pixels.size(); ++i) {
        const bool a = labels.pixels[i] != 0, b = mask.pixels[i] >= 128;
        both += a && b;
        either += a || b;
    }
    return either ? double(both) / double(either) : 1;
}

}  // namespace

FrameMeasures measureFrame(const Scan& scan, const ScanFrame& frame) {
    FrameMeasures out;
    FrameCheck& check = out.check;
    check.name = frame.name;
    const auto refuse = [&](const Error& error) {
        check.usable = false;
        if (check.error.empty()) check.error = error.message;
    };
    const auto image = readFrameImage(frame);
    if (!image) refuse(image.error());
    std::vector<Keypoint> keypoints;
    if (auto read = readKeypoints(scan, frame))
        keypoints = std::move(*read);
    else
        refuse(read.error());
    ImageGrey8 mask, labels;
    if (!frame.maskPath.empty()) {
        if (auto read = readFrameMask(frame))
            mask = std::move(*read);
        else
            refuse(read.error());
    }
    if (!frame.labelsPath.empty()) {
        if (auto read = readFrameLabels(frame))
            labels = std::move(*read);
        else
            refuse(read.error());
    }
    if (frame.split == Split::Test || !image) return out;
    check.measured = true;
    measureImage(*image, mask, check);
    if (!mask.pixels.empty()) {
        measureMask(mask, check);
        if (!keypoints.empty()) check.keypointsOnPerson = keypointsOnMask(keypoints, mask);
        if (!labels.pixels.empty()) out.labelAgreement = labelIou(labels, mask);
    }
    out.mask = std::move(mask);
    out.keypoints = std::move(keypoints);
    return out;
}

}  // namespace dpl
