// SPDX-License-Identifier: Apache-2.0
// Coverage samples (docs/adr/0005): at how many positions of a pixel splats are composited before the pixel is averaged.
//
// Blending takes the coverage of every splat as independent of the others. That holds where a pixel is no coarser than those that the
// avatar was trained at; in a coarser one the splats of a stack cover the same part of it, and 1 − Π(1 − mean αᵢ) is more opaque than
// mean(1 − Π(1 − αᵢ)).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "sdk/math/camera.h"

namespace dpl {

/** The positions from the pixel's top left corner: what graphics APIs call the standard locations of four samples. The low-pass of a sample
 * is a quarter of the pixel's. */
constexpr uint32_t kCoverageSamples = 4;
constexpr float kCoverageSamplePx[kCoverageSamples][2] = {{0.375f, 0.125f}, {0.875f, 0.375f}, {0.125f, 0.625f}, {0.625f, 0.875f}};
constexpr float kCoverageReachPx = 0.375f;  // of a sample from the pixel's centre, along x or y
constexpr float kCoarserPixel = 1.25f;      // measured (ADR 0005): one sample loses 0.4 dB there, four gain it back; earlier they only cost

/** Size of a pixel at the subject, metres; not above 0 or not finite where that is behind the view or a number is not finite. subject:
 * world. */
template <class T>
inline T pixelAtM(const PinholeCamera<T>& view, const Vec3<T>& subject) {
    return view.toView(subject).z / std::max(view.fx, view.fy);
}

/** 1 or kCoverageSamples, for all views of a frame alike. trainedPixelM: pixelAtM of the training; 0 = not known: 1 sample.
 *  subject: where the root joint is, world. Four where a pixel there is more than kCoarserPixel times the trained one, in the view that
 * sees the subject finest. Numbers that are not finite, a subject behind a view and no views give 1. */
inline uint32_t coverageSamples(float trainedPixelM, const Vec3f& subject, std::span<const Cameraf> views) {
    float finestM = views.empty() ? 0 : INFINITY;
    for (const Cameraf& view : views) {
        const float pixelM = pixelAtM(view, subject);
        finestM = pixelM < finestM ? pixelM : pixelM > 0 ? finestM : 0;  // NaN: 0
    }
    return trainedPixelM > 0 && finestM > kCoarserPixel * trainedPixelM && std::isfinite(finestM) ? kCoverageSamples : 1;
}

}  // namespace dpl
