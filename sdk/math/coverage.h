// SPDX-License-Identifier: Apache-2.0
// Coverage samples (docs/reference/coverage.md): splats are composited at one or four positions of a pixel and the results averaged.
//
// Blending assumes that splats cover a pixel independently. Training makes that fit for its own pixel size. In a coarser pixel, stacked
// splats cover the same part of it, and 1 − Π(1 − mean αᵢ) is more opaque than the true mean(1 − Π(1 − αᵢ)).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "sdk/math/camera.h"
#include "sdk/math/formulas/constants.h"

namespace dpl {

// Positions: kCoverageSamplePx in sdk/math/formulas/constants.h. Each sample has a quarter of the pixel's low-pass variance.
constexpr float kCoverageReachPx = 0.375f;  // largest distance of a sample from the pixel's centre along x or y
constexpr float kCoarserPixel = 1.25f;      // pixel size over trained size: here one sample loses 0.4 dB, which four samples gain back

/** Size of a pixel at the depth of the subject (world), metres. It is ≤ 0 or not finite when the subject is behind the view or a number is
 *  not finite. */
template <class T>
inline T pixelAtM(const PinholeCamera<T>& view, const Vec3<T>& subject) {
    return view.toView(subject).z / std::max(view.fx, view.fy);
}

/** Samples a pixel, one number for all views of a frame: kCoverageSamples when the finest pixel at the subject is more than kCoarserPixel
 *  times the trained one, else 1. trainedPixelM: pixelAtM of the training, 0 = unknown. subject: the root joint, world. Unknown numbers,
 *  numbers that are not finite, a subject behind a view, and no views give 1. */
inline uint32_t coverageSamples(float trainedPixelM, const Vec3f& subject, std::span<const Cameraf> views) {
    float finestM = views.empty() ? 0 : INFINITY;
    for (const Cameraf& view : views) {
        const float pixelM = pixelAtM(view, subject);
        finestM = pixelM < finestM ? pixelM : pixelM > 0 ? finestM : 0;  // 0 for NaN
    }
    return trainedPixelM > 0 && finestM > kCoarserPixel * trainedPixelM && std::isfinite(finestM) ? kCoverageSamples : 1;
}

}  // namespace dpl
