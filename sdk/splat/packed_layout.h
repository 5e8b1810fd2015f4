// SPDX-License-Identifier: Apache-2.0
// Layout and packing of a packed group: kGroupSplats = 16 splats, field by field. (A *group* is something else: 128 splats of a chunk.)
// Private to sdk/splat.
#pragma once

#include "sdk/math/sh.h"
#include "sdk/splat/packed_splats.h"

namespace dpl {

constexpr uint32_t kGroupSplats = 16;

/** Fields of bound splats. Angle and scales are stored as axes: A1 = axis10·F0 + axis11·F1, A2 = axis20·F0 + axis21·F1. */
namespace bound_field {
constexpr uint32_t kU = 0, kV = 1, kAxis10 = 2, kAxis11 = 3, kAxis20 = 4, kAxis21 = 5, kOpacity = 6, kSingleFace = 7, kCloth = 8,
                   kTriangle = 9, kSh = 10;
}
/** Fields of general splats. kAxes: the three columns of R·diag(s), metres. */
namespace static_field {
constexpr uint32_t kPosition = 0, kAxes = 3, kOpacity = 12, kSh = 13;
}

constexpr uint32_t groupFields(bool bound, uint32_t shDegree) {
    return (bound ? bound_field::kSh : static_field::kSh) + shCoefficientCount(shDegree) * 3;
}
constexpr uint32_t kMaxGroupFloats = groupFields(false, kMaxShDegree) * kGroupSplats;
constexpr size_t groupCount(size_t splats) {
    return (splats + kGroupSplats - 1) / kGroupSplats;
}

/** count(), or 0 and an error in the log when arrays differ in length or the SH degree is above kMaxShDegree. */
uint32_t usableCount(const BoundSplatView& splats);
uint32_t usableCount(const StaticSplatData& splats);

/** Packs splats [first, first + 16) into `out`; lanes past the last splat become invisible. The triangle index is stored as the bits of a
 *  float. order[new] = old; empty: as they come. */
void packGroup(const BoundSplatView& splats, uint32_t first, float* out);
void packGroup(const StaticSplatData& splats, uint32_t first, float* out, std::span<const uint32_t> order = {});

}  // namespace dpl
