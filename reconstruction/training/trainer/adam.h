// SPDX-License-Identifier: Apache-2.0
// The Adam optimiser in three forms: sparse SIMD rows for splats, uniform steps for meshes (docs/reference/large-steps.md), short vectors
// for poses.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/math/types.h"

namespace dpl {

constexpr float kAdamBeta1 = 0.9f, kAdamBeta2 = 0.999f;

/** Moments of N rows of `stride` floats (a multiple of eight). A row without a gradient in a step is skipped: its moments and its
 *  parameters stay. Each row therefore counts its own steps and corrects the bias of its moments by that count. */
struct AdamRows {
    uint32_t stride = 0;
    std::vector<float> first, second;  // N × stride
    std::vector<uint32_t> steps;       // N

    void resize(size_t count, uint32_t rowStride);

    /** values[i] −= rate ∘ m̂/(√v̂ + ε) for the rows i of [begin, end) with active[i] set. rate: `stride` learning rates, one a column. */
    void update(size_t begin, size_t end, std::span<const uint8_t> active, std::span<const float> gradients, std::span<const float> rate,
                std::span<float> values);
};

/** From so many steps on, the bias of the moments is below the rounding of a float. */
constexpr uint32_t kLastCorrection = 20001;

/** Rows of AdamRows, as their vector code takes them. */
struct AdamRange {
    size_t begin, end, stride;
    const uint8_t* active;
    const float *gradients, *rate;
    const float *correction1, *correction2;  // by the number of steps: undo the bias of the two moments
    uint32_t* steps;
    float *first, *second, *values;
};

/** Adam with the step m̂/(ε + max√v̂). The maximum is taken over all coordinates, so the step keeps the direction of m̂. */
struct AdamUniform {
    std::vector<Vec3f> first, second;
    uint32_t steps = 0;
    float beta1 = kAdamBeta1, beta2 = kAdamBeta2;

    void update(std::span<const Vec3f> gradient, float rate, std::span<Vec3f> value);
};

/** Plain Adam on a short vector (a pose). */
struct AdamVector {
    std::vector<double> first, second;
    uint32_t steps = 0;
    double beta1 = 0.9, beta2 = 0.99;

    /** Returns the step, which the caller subtracts. rates: one learning rate a coordinate. */
    std::vector<double> step(std::span<const double> gradient, std::span<const double> rates);
    /** √v̂ of each coordinate: what the last step divided by. */
    std::vector<double> spread() const;
};

}  // namespace dpl
