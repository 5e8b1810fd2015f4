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

/** The streams of a file. The three words a splat are CodedSplats' own. */
template <class Bytes>
struct SplatStreams {
    Bytes triangleCounts;  // LEB128, one a triangle
    Bytes chunks;          // SplatChunk records
    Bytes place, size, colour;
    Bytes shIndex;        // u16 a splat; encoding 2
    Bytes ranges, coded;  // encoding 3, instead of those above (splat_compact.h)
    Bytes sh;             // i8, ((degree+1)² − 1)·3 a splat, or a palette entry when there is a palette
};

/** What the file says beside the streams. paletteSize 0: every splat has its own SH. */
struct SplatHead {
    uint32_t count = 0, shDegree = 0, paletteSize = 0;
    std::optional<SplatBits> bits;  // encoding 3
};

/** Rounds to the nearest code. The splats must have passed checkAvatar; layers that do not tile the triangles count as one.
 *  shPalette: SH beyond coefficient 0 as a palette of its different rows; InvalidArgument when there are more than kMaxShPalette. */
Result<CodedSplats> codeSplats(const MeshData& mesh, const SplatData& splats, bool shPalette = false);

/** The numbers behind the codes, computed in double. */
SplatData decodeSplats(const CodedSplats& coded, size_t triangleCount);

/** Rounds the codes to so many bits, in place and so that decoding and coding again changes nothing. Range ends stay as they are. */
void coarsenSplats(CodedSplats& coded, const SplatBits& bits);

/** The fewest bits of each field that say all codes exactly. */
SplatBits neededBits(const CodedSplats& coded);

/** compact: `ranges` and `coded` instead of words, where that is smaller and no reader would be asked for more memory than a file may cost.
 */
SplatStreams<std::vector<uint8_t>> writeSplatStreams(const CodedSplats& coded, size_t triangleCount, bool compact = false);

/** Copies and checks splats bound to `mesh`. Every stream's length is checked before anything is allocated. */
Result<CodedSplats> readSplatStreams(const SplatStreams<std::span<const uint8_t>>& streams, const MeshData& mesh, const SplatHead& head,
                                     const ReadLimits& limits);

/** Morton code of the packed (u, v): 22 bits. */
uint32_t splatMorton(const Vec2f& uv);

}  // namespace dpl
