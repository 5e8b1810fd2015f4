// SPDX-License-Identifier: Apache-2.0
// Large Steps (docs/reference/large-steps.md): offsets = M⁻¹ u with M = I + λL, where L is the uniform graph Laplacian of the merged mesh.
//
// Vertices at the same position share one unknown, so seams do not tear. M is symmetric, so the backward pass is the same solve. M⁻¹ leaves
// constants unchanged, so the mean of a connected component can be removed from the offsets: for a body, whose place the pose tells, and
// not for a garment, which may move as a whole.
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
    /** Factors M. λ = (smoothingLengthM / mean edge)², so that a subdivided mesh is smoothed over the same distance. InvalidArgument:
     * indices out of range, non-finite positions, no edges. Internal: the factorisation failed. */
    static Result<LargeSteps> create(std::span<const Vec3f> positions, std::span<const Triangle> triangles, double smoothingLengthM);
    /** The same with a given λ ≥ 0. */
    static Result<LargeSteps> createWithLambda(std::span<const Vec3f> positions, std::span<const Triangle> triangles, double lambda);

    LargeSteps(LargeSteps&&) noexcept;
    LargeSteps& operator=(LargeSteps&&) noexcept;
    ~LargeSteps();

    /** Number of unknowns (merged vertices). */
    uint32_t size() const;
    double lambda() const;
    uint32_t componentCount() const;

    /** Offsets of all vertices (metres) from u (size() entries). Components that contain one of the first `heldVertices` vertices lose
     *  their mean. */
    void offsets(std::span<const Vec3f> u, std::span<Vec3f> vertexOffsets, uint32_t heldVertices) const;
    /** ∂loss/∂u (size() entries) from ∂loss/∂offsets (all vertices): the transpose of offsets(). */
    void backward(std::span<const Vec3f> vertexGradient, std::span<Vec3f> uGradient, uint32_t heldVertices) const;
    /** y = M·x, size() entries each: the u that belongs to given offsets. */
    void apply(std::span<const Vec3d> x, std::span<Vec3d> y) const;
    /** Solves M·x = b in place, size() entries, with three right-hand sides (x, y, z) at once. */
    void solve(std::span<Vec3d> x) const;

private:
    struct Factor;
    explicit LargeSteps(std::unique_ptr<Factor> factor);
    std::unique_ptr<Factor> factor_;
};

}  // namespace dpl
