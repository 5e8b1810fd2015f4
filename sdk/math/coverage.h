// SPDX-License-Identifier: Apache-2.0
// Coverage samples (docs/reference/coverage.md): at how many positions of a pixel splats are composited before the pixel is averaged.
//
// Blending treats the coverage of every splat as independent of the others. That holds while a pixel is no coarser than those that the
// avatar was trained at. In a coarser pixel the splats of a stack cover the same part, and 1 − Π(1 − mean αᵢ) is more opaque than
// mean(1 − Π(1 − αᵢ)).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "sdk/math/camera.h"
#include "sdk/math/formulas/constants.h"

namespace dpl {

// Each of the kCoverageSamples (sdk/math/formulas/constants.h) has a quarter of the pixel's low-pass variance.
constexpr float kCoverageReachPx = 0.375f;  // of a sample from the pixel's centre, along x or y
constexpr float kCoarserPixel = 1.25f;      // one sample loses 0.4 dB there and four gain it back; in finer pixels four only cost

/** Size of a pixel at the subject, metres. Not above 0, or not finite, when the subject is behind the view or a number is not finite.
 *  subject: world. */
template <class T>
inline T pixelAtM(const PinholeCamera<T>& view, const Vec3<T>& subject) {
    return view.toView(subject).z / std::max(view.fx, view.fy);
}

/** Samples a pixel of all views of a frame: 1, or kCoverageSamples where a pixel at the subject is more than kCoarserPixel times the
 *  trained one in the view that sees it finest. trainedPixelM: pixelAtM of the training, 0 = unknown. subject: the root joint, world.
 *  Unknown or not finite numbers, a subject behind a view and no views give 1. */
inline uint32_t coverageSamples(float trainedPixelM, const Vec3f& subject, std::span<const Cameraf> views) {
    float finestM = views.empty() ? 0 : INFINITY;
    for (const Cameraf& view : views) {
        const float pixelM = pixelAtM(view, subject);
        finestM = pixelM < finestM ? pixelM : pixelM > 0 ? finestM : 0;  // NaN: 0
    }
    return trainedPixelM > 0 && finestM > kCoarserPixel * trainedPixelM && std::isfinite(finestM) ? kCoverageSamples : 1;
}

}  // namespace dpl
