// Splat encodings 1 and 2 (docs/formats/avatar.md): SplatData <-> CodedSplats <-> the streams of a file.
#pragma once

#include <cstdint>
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
    Bytes triangleCounts;   // LEB128, one a triangle
    Bytes chunks;           // SplatChunk records
    Bytes place, size, colour;
    Bytes shIndex;          // u16 a splat; encoding 2
    Bytes sh;               // i8, ((degree+1)² − 1)·3 a splat, or a palette entry in encoding 2
};

/** What the file says beside the streams. paletteSize 0: encoding 1, every splat has its own SH. */
struct SplatHead {
    uint32_t count = 0, shDegree = 0, paletteSize = 0;
};

/** Rounds to the nearest code. The splats must have passed checkAvatar; layers that do not tile the triangles count as one.
 *  shPalette: SH beyond coefficient 0 as a palette of its different rows; InvalidArgument when there are more than kMaxShPalette. */
Result<CodedSplats> codeSplats(const MeshData& mesh, const SplatData& splats, bool shPalette = false);

/** The numbers behind the codes, computed in double. */
SplatData decodeSplats(const CodedSplats& coded, size_t triangleCount);

SplatStreams<std::vector<uint8_t>> writeSplatStreams(const CodedSplats& coded, size_t triangleCount);

/** Copies and checks splats bound to `mesh`. Every stream's length is checked before anything is allocated. */
Result<CodedSplats> readSplatStreams(const SplatStreams<std::span<const uint8_t>>& streams, const MeshData& mesh, const SplatHead& head, const ReadLimits& limits);

/** Morton code of the packed (u, v): 22 bits. */
uint32_t splatMorton(const Vec2f& uv);

}  // namespace dpl
