// SPDX-License-Identifier: Apache-2.0
// Skin weights as they ship: four joints a vertex, unorm8, sum 255.
#pragma once

#include <span>
#include <utility>

#include "sdk/math/types.h"

namespace dpl {

struct PackedWeights {
    glm::u16vec4 joints{0};
    glm::u8vec4 weights{0};
};

/** Keeps the four largest weights, renormalises and rounds to unorm8 by largest remainder, so that they sum to 255; sorted by falling
 *  weight, equal weights by joint. Equal joints are merged, negative and non-finite weights count as 0. All zero: joint 0 with weight 255.
 */
PackedWeights packWeights(std::span<const std::pair<uint32_t, float>> jointAndWeight);

}  // namespace dpl
