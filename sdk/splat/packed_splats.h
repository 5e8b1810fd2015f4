// SPDX-License-Identifier: Apache-2.0
// Splats in the engine's own layout: packed groups of sixteen splats, one array a field within a packed group.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"
#include "sdk/math/types.h"

namespace dpl {

/** Splats bound to triangles, one array a field, borrowed for the call. All spans but sh have one entry a splat. */
struct BoundSplatView {
    std::span<const uint32_t> triangle;
    std::span<const Vec2f> uv;
    std::span<const float> phi;     // radians
    std::span<const Vec2f> scaleM;  // standard deviations at rest
    std::span<const float> opacity;
    std::span<const uint8_t> flags;
    uint32_t shDegree = 0;
    std::span<const float> sh;  // coefficient-major, (degree+1)²·3 a splat
    uint32_t count() const { return uint32_t(triangle.size()); }
};

/** A copy of splats in the engine's layout, for sets that are drawn more than once. Immutable, so threads may share it. Empty, with an
 *  error in the log, when the input's arrays differ in length or its SH degree is above kMaxShDegree.
 *
 *      field 0: 16 floats | field 1: 16 floats | ...      one packed group; the last is padded with invisible splats
 */
class PackedSplats {
public:
    PackedSplats() = default;
    explicit PackedSplats(const BoundSplatView& splats);
    /** order[new] = old; empty: as they come. */
    explicit PackedSplats(const StaticSplatData& splats, std::span<const uint32_t> order = {});

    uint32_t count() const { return count_; }
    uint32_t shDegree() const { return shDegree_; }
    bool bound() const { return bound_; }
    const float* data() const { return data_.get(); }
    uint64_t bytes() const;

private:
    struct Free {
        void operator()(float* p) const;
    };
    std::unique_ptr<float[], Free> data_;
    uint32_t count_ = 0, shDegree_ = 0;
    bool bound_ = false;
};

}  // namespace dpl
