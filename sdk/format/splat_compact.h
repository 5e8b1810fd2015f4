// SPDX-License-Identifier: Apache-2.0
// Splat encoding 3: the same words in fewer bytes. Fields rounded to fewer bits (SplatBits), predicted from the splats before,
// entropy-coded.
#pragma once

#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/splat_codec.h"

namespace dpl {

constexpr uint32_t kMinCompactBytes = 4;  // of `coded` a splat: what a reader allocates is bounded by what it was given

/** Fills `ranges` and `coded` from words that need neededBits(coded). start: splats of each triangle, a prefix sum. */
void writeCompact(const CodedSplats& coded, const std::vector<uint32_t>& start, SplatStreams<std::vector<uint8_t>>& out);

/** Chunks, words and palette indices into `out`; returns the splats of each triangle, a prefix sum. Lengths are checked before anything is
 *  allocated, everything decoded after; that indices are in the palette is the caller's to check. head.bits must be there. */
Result<std::vector<uint32_t>> readCompact(const SplatStreams<std::span<const uint8_t>>& in, const MeshData& mesh, const SplatHead& head,
                                          CodedSplats& out);

}  // namespace dpl
