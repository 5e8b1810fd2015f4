// SPDX-License-Identifier: Apache-2.0
// Splats as they lie in the file and in the memory of every renderer: codes, and what turns them into numbers. No behaviour.
#pragma once

#include <cstdint>
#include <vector>

namespace dpl {

constexpr uint32_t kSplatChunkSize = 256;  // unit of compression and of culling; a chunk never straddles a layer
constexpr float kMinSplatScaleM = 1e-4f;   // smaller standard deviations are raised to this

// place: u 11 | v 11 | φ 10. 0 and 1 are exact, and a splat may overshoot its triangle by 6 %.
constexpr int kUvZero = 113;
constexpr double kUvSteps = 1820;
constexpr uint32_t kPhiSteps = 1024;  // half a turn: a covariance is the same at φ and φ + π
// size: s1 11 | s2 11 | opacity 8 | single-face 1 | cloth 1
constexpr uint32_t kScaleCodes = 2047;
constexpr uint32_t kSingleFaceBit = 1u << 30;
// colour: red 10 | green 11 | blue 11 of SH coefficient 0
constexpr uint32_t kColourCodes[3] = {1023, 2047, 2047};
constexpr uint32_t kMaxShPalette = 65536;

/** How many bits a file keeps of each field; as here, all that there are. Codes of fewer bits are spread evenly over the words' own, ends
 * included. */
struct SplatBits {
    uint8_t uv = 11, phi = 10, scale = 11, opacity = 8;
    uint8_t colour = 11;  // of green and blue; red has one less
    bool operator==(const SplatBits&) const = default;
};

/** One chunk as it lies in the file. Ranges are values that occur in the chunk, so encoding again finds the same ranges. */
struct SplatChunk {
    uint32_t firstSplat = 0, splatCount = 0;
    uint32_t firstTriangle = 0, endTriangle = 0;  // triangles of its first and, plus one, of its last splat
    float scaleMinM = 0, scaleMaxM = 0;
    float dcMin[3] = {0, 0, 0}, dcMax[3] = {0, 0, 0};
    float shRange[3] = {0, 0, 0};  // largest magnitude of bands 1, 2, 3: of the chunk, or of the palette
    uint32_t firstParent = 0;      // in memory: where its triangles begin in CodedSplats::parents; 0 in the file
};
static_assert(sizeof(SplatChunk) == 64);

/** Bytes of one splat's or palette entry's SH codes beyond coefficient 0, in memory: a multiple of 4. */
constexpr uint32_t shEntryBytes(uint32_t shDegree) {
    return (((shDegree + 1) * (shDegree + 1) - 1) * 3 + 3) / 4 * 4;
}

/** Of a half-chunk, for level of detail (sdk/math/detail.h). */
struct SplatGroup {
    float areaM2 = 0;  // of surface at rest that one of its splats stands for; of face and hands more (measureDetail)
    float gain = 0;    // 0 to 1: how the covered area falls with the share of splats kept, as its power
    float enough = 1;  // 0 to 1: of the covered area, the part that lets only kDetailThrough more shine through
};

/** N splats in file order. 15.3 bytes a splat, 4 a triangle that carries any, and the SH entries. */
struct CodedSplats {
    uint32_t shDegree = 0;
    std::vector<SplatChunk> chunks;
    std::vector<uint32_t> parents;              // the triangles that carry splats: of one chunk at most 256, in order
    std::vector<uint8_t> parent;                // N: splat i sits on parents[chunk.firstParent + parent[i]]
    std::vector<uint32_t> place, size, colour;  // N
    std::vector<uint16_t> shIndex;              // N: which SH entry; empty: entry i is splat i's own
    std::vector<int8_t> sh;  // entries of shEntryBytes, coefficient-major, zeros behind; value = code · range of its band / 127

    std::vector<SplatGroup> groups;  // two a chunk; made by measureGroups, not in the file; empty: always drawn in full

    uint32_t count() const { return uint32_t(place.size()); }
    uint64_t bytes() const {
        return chunks.size() * sizeof(SplatChunk) + parents.size() * 4 + parent.size() + (place.size() + size.size() + colour.size()) * 4 +
               shIndex.size() * 2 + sh.size() + groups.size() * sizeof(SplatGroup);
    }
};

}  // namespace dpl
