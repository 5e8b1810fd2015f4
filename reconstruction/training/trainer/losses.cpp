// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/losses.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr size_t kGrain = 16;            // pixel rows a job
constexpr uint32_t kWindowReachPx = 10;  // SSIM's gradient at a pixel reads two windows of radius 5

constexpr float kByte = 1.0f / 255;

float sign(float x) {
    return x > 0 ? 1.0f : x < 0 ? -1.0f : 0.0f;
}

/** What a pixel shows where the drawing is transparent. */
Vec3f behindPerson(const PictureTarget& target, size_t pixel, const Vec3f& background) {
    if (target.unsure.empty() || target.unsure[pixel] == 0) return background;
    const size_t pixels = size_t(target.widthPx) * target.heightPx;
    const uint8_t* behind = target.behind.data() + pixel;
    return kByte * Vec3f(behind[0], behind[pixels], behind[2 * pixels]) + (1 - kByte * float(target.unsure[pixel])) * background;
}

}  // namespace

PictureLoss::Box PictureLoss::shownBox(const SplatImage& image, const PictureTarget& target) {
    const uint32_t width = target.widthPx, height = target.heightPx;
    rowSpans_.resize(height);
    jobs_.forRange(height, kGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t y = begin; y < end; ++y) {
            const float* alpha = image.alpha.data() + y * width;
            const uint8_t* mask = target.mask.data() + y * width;
            const uint8_t* cloth = target.cloth.empty() ? mask : target.cloth.data() + y * width;
            const uint8_t* shown = target.shown.empty() ? mask : target.shown.data() + y * width;
            const auto shows = [&](uint32_t x) { return alpha[x] != 0 || mask[x] || cloth[x] || shown[x]; };
            uint32_t first = 0, last = width;
            while (first < width && !shows(first)) ++first;
            while (last > first && !shows(last - 1)) --last;
            rowSpans_[y] = {first, last};
        }
    });
    Box box{width, height, 0, 0};
    for (uint32_t y = 0; y < height; ++y) {
        const auto [first, last] = rowSpans_[y];
        if (first == last) continue;
        box.x0 = std::min(box.x0, first), box.x1 = std::max(box.x1, last);
        box.y0 = std::min(box.y0, y), box.y1 = y + 1;
    }
    if (box.x1 == 0) return {};
    box.x0 -= std::min(box.x0, kWindowReachPx), box.y0 -= std::min(box.y0, kWindowReachPx);
    box.x1 = std::min(width, box.x1 + kWindowReachPx), box.y1 = std::min(height, box.y1 + kWindowReachPx);
    return box;
}

LossValues PictureLoss::run(const SplatImage& image, const PictureTarget& target, const LossWeights& weights, const Vec3f& background,
                            ImageGradient& gradient) {
    const uint32_t width = target.widthPx, height = target.heightPx;
    const size_t pixels = size_t(width) * height;
    const bool withCloth = weights.cloth > 0 && !target.cloth.empty() && !image.cloth.empty();
    gradient.resize(width, height, withCloth);
    const Box box = shownBox(image, target);
    const uint32_t boxWidth = box.x1 - box.x0, boxHeight = box.y1 - box.y0;
    const size_t boxPixels = size_t(boxWidth) * boxHeight;
    drawn_.resize(boxWidth, boxHeight, 3), wanted_.resize(boxWidth, boxHeight, 3), colourGradient_.resize(boxWidth, boxHeight, 3);
    constexpr size_t kSums = 5;
    rowSums_.assign(size_t(height) * kSums, 0.0);
    const float l1Step = weights.l1 / float(pixels * 3), maskStep = weights.mask / float(pixels), clothStep = weights.cloth / float(pixels);

    jobs_.forRange(boxHeight, kGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t y = begin; y < end; ++y) {
            double* sums = rowSums_.data() + y * kSums;
            for (uint32_t x = 0; x < boxWidth; ++x) {
                const size_t i = (box.y0 + y) * width + box.x0 + x, at = y * boxWidth + x;
                const float alpha = image.alpha[i], mask = kByte * float(target.mask[i]);
                const Vec3f behind = behindPerson(target, i, background);
                const float shown = target.shown.empty() ? mask : kByte * float(target.shown[i]);
                for (uint32_t c = 0; c < 3; ++c) {
                    const float drawn = image.rgb[i * 3 + c] + (1 - alpha) * behind[int(c)];
                    const float wanted = kByte * float(target.rgb[c * pixels + i]) + (1 - shown) * background[int(c)];
                    const float error = drawn - wanted;
                    drawn_.values[c * boxPixels + at] = drawn, wanted_.values[c * boxPixels + at] = wanted;
                    colourGradient_.values[c * boxPixels + at] = l1Step * sign(error);
                    sums[0] += std::abs(error);
                    if (mask >= 0.5f) sums[3] += double(error) * error, sums[4] += 1;
                }
                const float maskError = alpha - mask;
                const float share = target.unsure.empty() ? 0 : kByte * float(target.unsure[i]);
                const float maskWeight = 1 + (target.edgeMaskWeight - 1) * share;
                gradient.alpha[i] = maskStep * maskWeight * sign(maskError);
                sums[1] += maskWeight * std::abs(maskError);
                if (withCloth) {
                    const float cloth = kByte * float(target.cloth[i]), clothError = image.cloth[i] - cloth;
                    gradient.colourShare[0][i] = 1 - cloth, gradient.colourShare[1][i] = 1 - std::max(0.0f, mask - cloth);
                    gradient.cloth[i] = clothStep * sign(clothError);
                    sums[2] += std::abs(clothError);
                }
            }
        }
    });
    LossValues v;
    for (size_t y = 0; y < boxHeight; ++y) {
        const double* sums = rowSums_.data() + y * kSums;
        v.l1 += sums[0], v.mask += sums[1], v.cloth += sums[2], v.squaredError += sums[3], v.squaredCount += sums[4];
    }
    v.l1 /= double(pixels * 3), v.mask /= double(pixels), v.cloth /= double(pixels);
    if (weights.ssim > 0) v.ssim = 1 - ssim_.run(drawn_, wanted_, &colourGradient_, -weights.ssim, pixels - boxPixels);
    v.total = weights.l1 * v.l1 + weights.ssim * v.ssim + weights.mask * v.mask + (withCloth ? weights.cloth * v.cloth : 0);

    jobs_.forRange(height, kGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t y = begin; y < end; ++y) {
            const bool inside = y >= box.y0 && y < box.y1;
            const size_t row = y * width, left = inside ? box.x0 : width, right = inside ? box.x1 : width;
            for (std::vector<float>* plane : {&gradient.red, &gradient.green, &gradient.blue, &gradient.alpha, &gradient.cloth}) {
                if (plane->empty()) continue;
                std::fill_n(plane->data() + row, left, 0.0f);
                std::fill_n(plane->data() + row + right, width - right, 0.0f);
            }
            for (size_t x = left; x < right; ++x) {
                const size_t i = row + x, at = (y - box.y0) * boxWidth + x - left;
                const float r = colourGradient_.values[at], g = colourGradient_.values[boxPixels + at],
                            b = colourGradient_.values[2 * boxPixels + at];
                gradient.red[i] = r, gradient.green[i] = g, gradient.blue[i] = b;
                const Vec3f behind = behindPerson(target, i, background);
                gradient.alpha[i] -= r * behind.x + g * behind.y + b * behind.z;
            }
        }
    });
    return v;
}

}  // namespace dpl
