// SPDX-License-Identifier: Apache-2.0
// The published scores once more: in double precision, pixel by pixel from their formulas, sharing no code with what they check.
#pragma once

#include <cmath>
#include <functional>

#include "reconstruction/input/capture/scan.h"

namespace dpl::test {

/** A channel of a pixel in [0, 1]. */
using PixelValue = std::function<double(int x, int y, int c)>;

inline double naivePsnrDb(const PixelValue& a, const PixelValue& b, int width, int height) {
    double sum = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) sum += std::pow(a(x, y, c) - b(x, y, c), 2);
    return 10 * std::log10(1 / (sum / (3.0 * width * height)));
}

/** Windows of 11 × 11 that lie wholly inside the picture. */
inline double naiveSsim(const PixelValue& a, const PixelValue& b, int width, int height) {
    double total = 0;
    for (int c = 0; c < 3; ++c)
        for (int y = 5; y < height - 5; ++y)
            for (int x = 5; x < width - 5; ++x) {
                double weights = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
                for (int j = -5; j <= 5; ++j)
                    for (int i = -5; i <= 5; ++i) {
                        const double w = std::exp(-(i * i + j * j) / (2 * 1.5 * 1.5)), p = a(x + i, y + j, c), q = b(x + i, y + j, c);
                        weights += w, ma += w * p, mb += w * q, aa += w * p * p, bb += w * q * q, ab += w * p * q;
                    }
                ma /= weights, mb /= weights;
                const double va = aa / weights - ma * ma, vb = bb / weights - mb * mb, cov = ab / weights - ma * mb;
                total += (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
            }
    return total / (3.0 * (width - 10) * (height - 10));
}

/** What the protocol compares: the frame, or an RGBA picture, white outside the frame's mask. Drawn pictures are rounded to 8 bits. */
inline PixelValue publishedPixel(const ImageRgb8& image, const ImageGrey8& mask) {
    return [&](int x, int y, int c) {
        const size_t i = size_t(y) * image.widthPx + size_t(x);
        const double m = mask.pixels[i] / 255.0;
        return image.pixels[3 * i + size_t(c)] / 255.0 * m + 1 - m;
    };
}
inline PixelValue publishedPixel(const std::vector<uint8_t>& rgba, const ImageGrey8& mask) {
    return [&](int x, int y, int c) {
        const size_t i = size_t(y) * mask.widthPx + size_t(x);
        const double m = mask.pixels[i] / 255.0, alpha = rgba[4 * i + 3] / 255.0;
        return std::floor(rgba[4 * i + size_t(c)] * alpha + 255 * (1 - alpha) + 0.5) / 255.0 * m + 1 - m;
    };
}

}  // namespace dpl::test
