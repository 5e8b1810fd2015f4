// SPDX-License-Identifier: Apache-2.0
// LargeSteps (docs/reference/large-steps.md): offsets = (I + λL)⁻¹ u with L the uniform graph Laplacian of the merged mesh.
//
// Vertices at the same place are one unknown, so seams do not tear. M is symmetric: the backward pass is the same solve. M passes
// constants with gain 1, so the mean of every connected component can be projected out.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/math/types.h"

namespace dpl {

class LargeSteps {
public:
    /** Factors M once. smoothingLengthM: λ = (ℓ / mean edge)², so that a subdivided mesh smooths alike. Fails on indices out of
     *  range, non-finite positions, or when the factorisation breaks down. */
    static Result<LargeSteps> create(std::span<const Vec3f> positions, std::span<const Triangle> triangles, double smoothingLengthM = 0.04);
    /** The same with λ given. */
    static Result<LargeSteps> createWithLambda(std::span<const Vec3f> positions, std::span<const Triangle> triangles, double lambda);

    LargeSteps(LargeSteps&&) noexcept;
    LargeSteps& operator=(LargeSteps&&) noexcept;
    ~LargeSteps();

    /** Unknowns: merged vertices. */
    uint32_t size() const;
    double lambda() const;
    uint32_t componentCount() const;

    /** u (size() entries) -> offsets of all vertices, mean of each component removed when `removeMean`. */
    void offsets(std::span<const Vec3f> u, std::span<Vec3f> vertexOffsets, bool removeMean) const;
    /** ∂loss/∂offsets (all vertices) -> ∂loss/∂u: the transpose of offsets(). */
    void backward(std::span<const Vec3f> vertexGradient, std::span<Vec3f> uGradient, bool removeMean) const;
    /** M·x for tests and for starting from given offsets. x, y: size() entries. */
    void apply(std::span<const Vec3d> x, std::span<Vec3d> y) const;
    /** Solves M·x = b in place. Three right-hand sides in one sweep over the factor. */
    void solve(std::span<Vec3d> x) const;

private:
    struct Factor;
    explicit LargeSteps(std::unique_ptr<Factor> factor);
    std::unique_ptr<Factor> factor_;
};

}  // namespace dpl
