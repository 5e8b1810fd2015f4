// SPDX-License-Identifier: Apache-2.0
// Splats for the optimiser: one row of raw parameters a splat, and the linear values that the engine draws.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"
#include "sdk/math/sh.h"
#include "sdk/splat/splat_engine.h"

namespace dpl {

// Columns of a row. A row is padded to a multiple of eight floats so that Adam updates whole vectors.
constexpr uint32_t kRowU = 0, kRowV = 1, kRowPhi = 2, kRowLogScale1 = 3, kRowLogScale2 = 4, kRowOpacityLogit = 5, kRowSh = 6;

constexpr float kMinLogScale = -9.0f;  // ln metres, 0.12 mm: smaller splats get no gradient (docs/reference/footprint.md)
constexpr float kMaxLogScale = -2.3f;  // ln metres, 10 cm
constexpr float kMaxOpacityLogit = 8.0f;

/** N splats, always sorted by triangle (stable), so that sums over a triangle's splats are contiguous. */
struct TrainableSplats {
    uint32_t shDegree = 0, stride = 0;
    std::vector<uint32_t> triangle;       // N, ascending
    std::vector<uint32_t> triangleStart;  // F+1
    std::vector<uint8_t> flags;           // N
    std::vector<float> rows;              // N × stride: raw parameters
    std::vector<float> sizeFloorM;        // F: in-plane size floor of the triangle (see TriangleSight), metres at rest

    // Linear values; activate() computes them from `rows`.
    std::vector<Vec2f> uv, scaleM;  // scaleM² = exp(2·logScale) + floor²
    std::vector<float> phi, opacity, sh;

    uint32_t count() const { return uint32_t(triangle.size()); }
    static uint32_t strideFor(uint32_t shDegree) { return (kRowSh + shCoefficientCount(shDegree) * 3 + 7) / 8 * 8; }

    /** Resizes the arrays of N to `count` splats and sets rows to zero. The caller fills triangleStart and sizeFloorM. */
    void resize(uint32_t count, uint32_t degree);
    /** Computes triangleStart from `triangle`. */
    void indexTriangles(size_t triangleCount);
    /** Projects (u, v) into the triangle, clamps scales and opacity, and recomputes the linear values of the splats in [begin, end). With
     *  `only` (one byte a splat), does so only for splats whose byte is not zero. */
    void activate(size_t begin, size_t end, std::span<const uint8_t> only = {});
    void activateAll(Jobs& jobs);
    BoundSplatView view() const;

    /** The linear values as an avatar's splats, in the same order. */
    SplatData toSplatData() const;
    /** Rows from an avatar's splats. A scale below the floor is raised to it. */
    static TrainableSplats fromSplatData(const SplatData& splats, std::span<const float> sizeFloorM);
};

/** Projection of (u, v) onto {u ≥ 0, v ≥ 0, u + v ≤ 1}, Euclidean in the barycentric coordinates (1 − u − v, u, v). */
Vec2f projectToSimplex(Vec2f uv);

}  // namespace dpl
