// SPDX-License-Identifier: Apache-2.0
// Adam over parameter rows (SIMD, sparse) and its uniform variant for meshes (docs/reference/large-steps.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/math/types.h"

namespace dpl {

constexpr float kAdamBeta1 = 0.9f, kAdamBeta2 = 0.999f;

/** Moments of N rows of `stride` floats (a multiple of eight). Rows that saw no gradient in a step are skipped whole: neither
 *  moments nor parameters move, and each row corrects its bias by the number of its own steps. */
struct AdamRows {
    uint32_t stride = 0;
    std::vector<float> first, second;  // N × stride
    std::vector<uint32_t> steps;       // N

    void resize(size_t count, uint32_t rowStride);

    /** value[i] −= rate ∘ m̂/(√v̂ + ε) for rows with active[i], over [begin, end). rate: `stride` learning rates. */
    void update(size_t begin, size_t end, std::span<const uint8_t> active, std::span<const float> gradients, std::span<const float> rate,
                std::span<float> values);
};

/** Adam whose step is m̂/(ε + max√v̂) over a whole tensor of 3-vectors: the direction is not distorted per coordinate. */
struct AdamUniform {
    std::vector<Vec3f> first, second;
    uint32_t steps = 0;
    float beta1 = kAdamBeta1, beta2 = kAdamBeta2;

    void update(std::span<const Vec3f> gradient, float rate, std::span<Vec3f> value);
};

/** Plain Adam on a short vector (poses, cameras), with its own moments. */
struct AdamVector {
    std::vector<double> first, second;
    uint32_t steps = 0;
    double beta1 = 0.9, beta2 = 0.99;

    /** Returns the step to subtract; rates has one entry a coordinate. */
    std::vector<double> step(std::span<const double> gradient, std::span<const double> rates);
};

}  // namespace dpl
