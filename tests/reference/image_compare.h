// SPDX-License-Identifier: Apache-2.0
// Comparison of pictures: PSNR, largest error, and the share of covered pixels.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace dpl {

struct ImageDifference {
    double psnrDb = 0;    // peak 1, over all values; infinite for equal images
    double maxError = 0;  // infinite when sizes differ or a value is not finite
    size_t worst = 0;     // index of the largest error
};

/** Both images must use the same scale, [0,1] for colours. */
template <class A, class B>
ImageDifference compareImages(const A& actual, const B& expected) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    if (actual.size() != expected.size()) return {0, kInfinite, 0};
    ImageDifference d{kInfinite, 0, 0};
    double squares = 0;
    for (size_t i = 0; i < actual.size(); ++i) {
        const double error = std::abs(double(actual[i]) - double(expected[i]));
        if (!std::isfinite(error)) return {0, kInfinite, i};
        if (error > d.maxError) d.maxError = error, d.worst = i;
        squares += error * error;
    }
    if (squares > 0) d.psnrDb = -10 * std::log10(squares / double(actual.size()));
    return d;
}

/** Share of pixels with alpha above `threshold`. Tests require some, because comparing two empty images proves nothing. */
template <class Image>
double coverage(const Image& alpha, double threshold = 0.1) {
    if (alpha.empty()) return 0;
    return double(std::count_if(alpha.begin(), alpha.end(), [&](auto a) { return double(a) > threshold; })) / double(alpha.size());
}

}  // namespace dpl
