// SPDX-License-Identifier: Apache-2.0
// Correctives encoding 2: codes the three large streams of encoding 1 without loss in fewer bytes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/correctives.h"

namespace dpl {

/** Entropy-codes `nodes`, `nodeIndices` and `nodeWeights` of streams from encodeCorrectives (sdk/format/entropy.h). */
std::vector<uint8_t> compactCorrectives(const CorrectiveStreams<std::vector<uint8_t>>& streams, uint32_t nodeCount);

/** Restores these three streams; the others stay empty. columnCount: values of a node, as PoseCorrectiveData::columnCount(). Checks lengths
 * before it allocates. */
Result<CorrectiveStreams<std::vector<uint8_t>>> expandCorrectives(std::span<const uint8_t> coded, uint32_t columnCount, uint32_t nodeCount,
                                                                  size_t vertexCount);

}  // namespace dpl
