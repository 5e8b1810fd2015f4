// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** order[new] = old: points along a Morton curve of 2^21 cells an axis over where most of them are, so that neighbours in memory are
 * neighbours in space. What lies outside of that, is infinite or not a number goes to the cells at its ends. Equal cells keep their order.
 */
std::vector<uint32_t> spatialOrder(std::span<const Vec3f> points);

}  // namespace dpl
