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

/** Computes SSIM with separable blurs, with SIMD along rows. Pixels outside the image count as zero. Rows are kept in small rings, so that
 *  values that are read eleven times stay in the second-level cache. */
class Ssim {
public:
    explicit Ssim(Jobs& jobs) : jobs_(jobs) {}

    /** Mean SSIM of x against y over all pixels and channels. Adds weight · ∂mean/∂x to `gradient` (same size as x) unless it is null.
     *  equalPixels: number of further pixels, outside these images, that are equal in both; each counts in the mean with SSIM 1. */
    double run(const PlanarImage& x, const PlanarImage& y, PlanarImage* gradient, float weight, size_t equalPixels = 0);

private:
    Jobs& jobs_;
    std::vector<float> rings_;  // one set of rings a worker
    std::vector<double> rowSums_;
};

}  // namespace dpl
