// SPDX-License-Identifier: Apache-2.0
// Splat encodings 1, 2 and 3 (docs/formats/avatar.md): SplatData <-> CodedSplats <-> the streams of a file.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/format/read_limits.h"

namespace dpl {

/** The streams of a file. place, size and colour are those of CodedSplats. */
template <class Bytes>
struct SplatStreams {
    Bytes triangleCounts;  // LEB128, one per triangle
    Bytes chunks;          // SplatChunk records
    Bytes place, size, colour;
    Bytes shIndex;        // u16 per splat; encoding 2
    Bytes ranges, coded;  // encoding 3: replace the streams above (splat_compact.h)
    Bytes sh;             // i8, ((degree+1)² − 1)·3 per splat, or per palette row
};

/** Numbers that the file stores beside the streams. paletteSize 0: every splat has its own SH. */
struct SplatHead {
    uint32_t count = 0, shDegree = 0, paletteSize = 0;
    std::optional<SplatBits> bits;  // encoding 3
};

/** Rounds each value to its nearest code. The splats must have passed checkAvatar; layers that do not tile the triangles count as one.
 *  shPalette: stores each different SH row once; InvalidArgument if there are more than kMaxShPalette. */
Result<CodedSplats> codeSplats(const MeshData& mesh, const SplatData& splats, bool shPalette = false);

/** Decodes, in double precision. */
SplatData decodeSplats(const CodedSplats& coded, size_t triangleCount);

/** Rounds the codes to these numbers of bits, in place. Decoding and coding again changes nothing. Ends of ranges do not change. */
void coarsenSplats(CodedSplats& coded, const SplatBits& bits);

/** The fewest bits per field that represent all codes exactly. */
SplatBits neededBits(const CodedSplats& coded);

/** compact: writes `ranges` and `coded` instead of words, if that is smaller and within the bound of memory per byte of file
 *  (kMinCompactBytes). */
SplatStreams<std::vector<uint8_t>> writeSplatStreams(const CodedSplats& coded, size_t triangleCount, bool compact = false);

/** Copies and checks splats bound to `mesh`. Checks the length of each stream before it allocates. */
Result<CodedSplats> readSplatStreams(const SplatStreams<std::span<const uint8_t>>& streams, const MeshData& mesh, const SplatHead& head,
                                     const ReadLimits& limits);

/** Morton code of the packed (u, v): 22 bits. */
uint32_t splatMorton(const Vec2f& uv);

}  // namespace dpl
