// SPDX-License-Identifier: Apache-2.0
// Splat encoding 3: stores the words without loss in fewer bytes. Fields may use fewer bits (SplatBits), are predicted from the splats
// before and entropy-coded.
#pragma once

#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/splat_codec.h"

namespace dpl {

constexpr uint32_t kMinCompactBytes = 4;  // bytes of `coded` per splat; bounds a reader's memory by the size of its input

/** Fills `ranges` and `coded` with fields of neededBits(coded) bits. start: prefix sum of the splats of each triangle. */
void writeCompact(const CodedSplats& coded, const std::vector<uint32_t>& start, SplatStreams<std::vector<uint8_t>>& out);

/** Reads chunks, words and palette indices into `out`. Returns the prefix sum of the splats of each triangle. Checks lengths before it
 *  allocates, and all decoded values except that palette indices are in range: the caller checks those. head.bits must be set. */
Result<std::vector<uint32_t>> readCompact(const SplatStreams<std::span<const uint8_t>>& in, const MeshData& mesh, const SplatHead& head,
                                          CodedSplats& out);

}  // namespace dpl
