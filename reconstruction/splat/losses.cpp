#include "reconstruction/splat/losses.h"

#include <algorithm>
#include <cmath>

namespace dpl {

LossValues PictureLoss::run(const SplatImage& image, const PictureTarget& target, const LossWeights& weights, const Vec3f& background,
                            ImageGradient& gradient) {
    const uint32_t width = target.widthPx, height = target.heightPx;
    const size_t pixels = size_t(width) * height;
    const bool withCloth = weights.cloth > 0 && !target.cloth.empty() && !image.cloth.empty();
    gradient.resize(width, height, withCloth);
    drawn_.resize(width, height, 3), wanted_.resize(width, height, 3), colourGradient_.resize(width, height, 3);
    constexpr size_t kSums = 5, kGrain = 16;
    rowSums_.assign(size_t(height) * kSums, 0.0);
    const float l1Step = weights.l1 / float(pixels * 3), maskStep = weights.mask / float(pixels), clothStep = weights.cloth / float(pixels);
    const auto sign = [](float x) { return x > 0 ? 1.0f : x < 0 ? -1.0f : 0.0f; };

    jobs_.forRange(height, kGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t y = begin; y < end; ++y) {
            double* sums = rowSums_.data() + y * kSums;
            for (size_t i = y * width; i < (y + 1) * width; ++i) {
                const float alpha = image.alpha[i], mask = target.mask[i];
                const float goal[3] = {target.red[i], target.green[i], target.blue[i]};
                const bool scored = !target.band[i];
                for (uint32_t c = 0; c < 3; ++c) {
                    const float drawn = image.rgb[i * 3 + c] + (1 - alpha) * background[int(c)];
                    const float wanted = scored ? goal[c] + (1 - mask) * background[int(c)] : drawn;
                    const float error = drawn - wanted;
                    drawn_.values[c * pixels + i] = drawn, wanted_.values[c * pixels + i] = wanted;
                    colourGradient_.values[c * pixels + i] = l1Step * sign(error);
                    sums[0] += std::abs(error);
                    if (mask >= 0.5f && scored) sums[3] += double(error) * error, sums[4] += 1;
                }
                const float maskError = alpha - mask;
                gradient.alpha[i] = maskStep * sign(maskError);
                sums[1] += std::abs(maskError);
                if (withCloth) {
                    const float clothError = image.cloth[i] - target.cloth[i];
                    gradient.cloth[i] = clothStep * sign(clothError);
                    sums[2] += std::abs(clothError);
                }
            }
        }
    });
    LossValues v;
    for (size_t y = 0; y < height; ++y) {
        const double* sums = rowSums_.data() + y * kSums;
        v.l1 += sums[0], v.mask += sums[1], v.cloth += sums[2], v.squaredError += sums[3], v.squaredCount += sums[4];
    }
    v.l1 /= double(pixels * 3), v.mask /= double(pixels), v.cloth /= double(pixels);
    if (weights.ssim > 0) v.ssim = 1 - ssim_.run(drawn_, wanted_, &colourGradient_, -weights.ssim);
    v.total = weights.l1 * v.l1 + weights.ssim * v.ssim + weights.mask * v.mask + (withCloth ? weights.cloth * v.cloth : 0);

    jobs_.forRange(height, kGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t i = begin * width; i < end * width; ++i) {
            if (target.band[i]) {
                gradient.red[i] = gradient.green[i] = gradient.blue[i] = 0;
                continue;
            }
            const float r = colourGradient_.values[i], g = colourGradient_.values[pixels + i], b = colourGradient_.values[2 * pixels + i];
            gradient.red[i] = r, gradient.green[i] = g, gradient.blue[i] = b;
            gradient.alpha[i] -= r * background.x + g * background.y + b * background.z;
        }
    });
    return v;
}

}  // namespace dpl
