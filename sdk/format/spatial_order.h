// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** Sorts points along a Morton curve, so that neighbours in memory are neighbours in space; order[new] = old. The grid has 2^21 cells per
 *  axis and covers most of the points. Points outside it or not finite count as points of its border cells. Points of the same cell keep
 *  their order. */
std::vector<uint32_t> spatialOrder(std::span<const Vec3f> points);

}  // namespace dpl
