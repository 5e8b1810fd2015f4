// SPDX-License-Identifier: Apache-2.0
// Skin weights as avatars store them: four joints per vertex, unorm8, sum 255.
#pragma once

#include <span>
#include <utility>

#include "sdk/math/types.h"

namespace dpl {

struct PackedWeights {
    glm::u16vec4 joints{0};
    glm::u8vec4 weights{0};
};

/** Merges equal joints, keeps the four largest weights, scales them and rounds them by largest remainder to unorm8 with the sum 255. Sorted
 *  by falling weight, then by joint. Negative and non-finite weights count as 0. If all are 0, joint 0 has weight 255. */
PackedWeights packWeights(std::span<const std::pair<uint32_t, float>> jointAndWeight);

/** packWeights() of a dense row, one weight a column, after its fifth largest weight is taken off all. So a joint that drops out of the
 * four has faded to nothing before; otherwise cloth tears where the four change. jointOf: of each column. */
PackedWeights cutToFour(std::span<const float> row, std::span<const uint32_t> jointOf);

}  // namespace dpl
