// SPDX-License-Identifier: Apache-2.0
// Correctives encoding 2: the three large streams of encoding 1 in fewer bytes, and back to the same bytes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/correctives.h"

namespace dpl {

/** `nodes`, `nodeIndices` and `nodeWeights` of streams that encodeCorrectives made, entropy-coded (sdk/format/entropy.h). */
std::vector<uint8_t> compactCorrectives(const CorrectiveStreams<std::vector<uint8_t>>& streams, uint32_t nodeCount);

/** The three streams again; the others are left empty. Lengths are checked before anything is allocated. */
Result<CorrectiveStreams<std::vector<uint8_t>>> expandCorrectives(std::span<const uint8_t> coded, uint32_t modeCount, uint32_t nodeCount,
                                                                  size_t vertexCount);

}  // namespace dpl
