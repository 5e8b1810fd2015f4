// Splat encoding 1 (docs/formats/avatar.md): three words a splat, ranges per chunk of up to 256, varint counts per triangle. Internal.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/read_limits.h"

namespace dpl {

/** One chunk as it lies in the file. Ranges are values that occur in the chunk, so encoding again finds the same ranges. */
struct SplatChunk {
    uint32_t firstSplat = 0, splatCount = 0;
    uint32_t firstTriangle = 0, endTriangle = 0;   // triangles of its first and, plus one, of its last splat
    float scaleMinM = 0, scaleMaxM = 0;
    float dcMin[3] = {0, 0, 0}, dcMax[3] = {0, 0, 0};
    float shRange[3] = {0, 0, 0};                  // largest magnitude of bands 1, 2, 3
    uint32_t pad0 = 0;
};
static_assert(sizeof(SplatChunk) == 64);

/** The streams of a file: owned when written, borrowed when read. */
template <class Bytes>
struct SplatStreams {
    Bytes triangleCounts;   // LEB128, one a triangle
    Bytes chunks;           // SplatChunk records
    Bytes place;            // u32 a splat: u 11 | v 11 | φ 10
    Bytes size;             // u32 a splat: s1 11 | s2 11 | opacity 8 | single-face 1 | cloth 1
    Bytes colour;           // u32 a splat: red 10 | green 11 | blue 11 of the first SH coefficient
    Bytes sh;               // i8, ((degree+1)² − 1)·3 a splat
};

/** Layers of the mesh must tile its triangles and the splats must have passed checkAvatar. */
SplatStreams<std::vector<uint8_t>> encodeSplats(const MeshData& mesh, const SplatData& splats);

/** Decodes `splatCount` splats bound to `mesh`. Every stream's length is checked before anything is allocated. */
Result<SplatData> decodeSplats(const SplatStreams<std::span<const uint8_t>>& streams, const MeshData& mesh, uint32_t splatCount, uint32_t shDegree,
                               const ReadLimits& limits);

/** Morton code of the packed (u, v): 22 bits. */
uint32_t splatMorton(const Vec2f& uv);

}  // namespace dpl
