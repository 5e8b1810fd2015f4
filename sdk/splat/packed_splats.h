// SPDX-License-Identifier: Apache-2.0
// Splats rearranged once for the engine: what never changes between frames, in groups of sixteen, structure of arrays inside a group.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"
#include "sdk/math/types.h"

namespace dpl {

/** Splats bound to triangles, structure of arrays, borrowed for the call. All spans have one entry a splat except sh. */
struct BoundSplatView {
    std::span<const uint32_t> triangle;
    std::span<const Vec2f> uv;
    std::span<const float> phi;
    std::span<const Vec2f> scaleM;
    std::span<const float> opacity;
    std::span<const uint8_t> flags;
    uint32_t shDegree = 0;
    std::span<const float> sh;  // coefficient-major, (degree+1)²·3 a splat
    uint32_t count() const { return uint32_t(triangle.size()); }
};

/** A copy of splats in the engine's own layout, for sets that are drawn more than once. Immutable; share it between threads freely.
 *
 *      field 0: 16 floats | field 1: 16 floats | ...      one group = sixteen splats; the last one is padded with invisible splats
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
