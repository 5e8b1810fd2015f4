// SPDX-License-Identifier: Apache-2.0
// Structural similarity with its gradient: 11×11 Gaussian window, σ = 1.5, C1 = 0.01², C2 = 0.03² (docs/reference/metrics.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/jobs.h"

namespace dpl {

/** A planar image: `channels` planes of heightPx rows of widthPx floats. */
struct PlanarImage {
    uint32_t widthPx = 0, heightPx = 0, channels = 0;
    std::vector<float> values;

    void resize(uint32_t width, uint32_t height, uint32_t channelCount) {
        widthPx = width, heightPx = height, channels = channelCount;
        values.resize(size_t(width) * height * channelCount);
    }
    size_t planeSize() const { return size_t(widthPx) * heightPx; }
    std::span<float> plane(uint32_t c) { return {values.data() + planeSize() * c, planeSize()}; }
    std::span<const float> plane(uint32_t c) const { return {values.data() + planeSize() * c, planeSize()}; }
};

/** Separable, SIMD over rows, zero outside the image (so the window shrinks no further than the crop's border). Rows roll through
 *  small rings: what is read eleven times stays in the second-level cache. */
class Ssim {
public:
    explicit Ssim(Jobs& jobs) : jobs_(jobs) {}

    /** Mean SSIM of x against y over all pixels and channels. With `gradient` (same size as x): adds weight · ∂mean/∂x.
     *  equalPixels: pixels beyond the pictures in which both agree; each counts as a similarity of 1. */
    double run(const PlanarImage& x, const PlanarImage& y, PlanarImage* gradient, float weight, size_t equalPixels = 0);

private:
    Jobs& jobs_;
    std::vector<float> rings_;  // one set a worker
    std::vector<double> rowSums_;
};

}  // namespace dpl
