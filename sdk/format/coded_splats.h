// SPDX-License-Identifier: Apache-2.0
// Splats as integer codes, in files and in the memory of all renderers, with the constants that decode them. No behaviour.
#pragma once

#include <cstdint>
#include <vector>

namespace dpl {

constexpr uint32_t kSplatChunkSize = 256;  // unit of compression; a chunk lies within one layer
constexpr float kMinSplatScaleM = 1e-4f;   // smaller standard deviations are raised to this value

// Word `place`, lowest bits first: u 11 | v 11 | φ 10. u and v of 0 and 1 are exact; a splat may lie up to 6 % outside its triangle.
constexpr int kUvZero = 113;
constexpr double kUvSteps = 1820;
constexpr uint32_t kPhiSteps = 1024;  // over half a turn, because φ and φ + π give the same covariance
// Word `size`: s1 11 | s2 11 | opacity 8 | single-face 1 | cloth 1
constexpr uint32_t kScaleCodes = 2047;
constexpr uint32_t kSingleFaceBit = 1u << 30;
// Word `colour`, SH coefficient 0: red 10 | green 11 | blue 11
constexpr uint32_t kColourCodes[3] = {1023, 2047, 2047};
constexpr uint32_t kMaxShPalette = 65536;

/** Bits that a file keeps of each field; the defaults keep all. Codes of fewer bits are spread evenly over the full range of the field,
 *  including both ends. */
struct SplatBits {
    uint8_t uv = 11, phi = 10, scale = 11, opacity = 8;
    uint8_t colour = 11;  // of green and blue; red has one bit less
    bool operator==(const SplatBits&) const = default;
};

/** One chunk, as stored in the file. The ends of ranges are values that occur in the chunk, so encoding again finds the same ranges. */
struct SplatChunk {
    uint32_t firstSplat = 0, splatCount = 0;
    uint32_t firstTriangle = 0, endTriangle = 0;  // triangle of its first splat; of its last splat, plus one
    float scaleMinM = 0, scaleMaxM = 0;
    float dcMin[3] = {0, 0, 0}, dcMax[3] = {0, 0, 0};
    float shRange[3] = {0, 0, 0};  // largest magnitude of bands 1, 2, 3, in the chunk or in the palette
    uint32_t firstParent = 0;      // index of its first triangle in CodedSplats::parents; 0 in the file
};
static_assert(sizeof(SplatChunk) == 64);

/** Bytes in memory of an SH entry: the codes beyond coefficient 0 of a splat or a palette row, padded to a multiple of 4. */
constexpr uint32_t shEntryBytes(uint32_t shDegree) {
    return (((shDegree + 1) * (shDegree + 1) - 1) * 3 + 3) / 4 * 4;
}

/** Values of a group for level of detail (docs/reference/level-of-detail.md). A group is the first or second half of a chunk. */
struct SplatGroup {
    float areaM2 = 0;  // surface at rest that one splat of the group stands for; scaled up on face and hands (measureDetail)
    float gain = 0;    // 0 to 1: the covered area is about proportional to share^gain, with the share of splats kept
    float enough = 1;  // 0 to 1: part of the covered area at which kDetailThrough more light passes through
};

/** N splats in file order. Memory: 15.3 bytes per splat, 4 per triangle that carries splats, and the SH entries. */
struct CodedSplats {
    uint32_t shDegree = 0;
    std::vector<SplatChunk> chunks;
    std::vector<uint32_t> parents;              // triangles that carry splats, at most 256 per chunk, rising within a chunk
    std::vector<uint8_t> parent;                // N: the parent of splat i is parents[chunk.firstParent + parent[i]]
    std::vector<uint32_t> place, size, colour;  // N
    std::vector<uint16_t> shIndex;              // N: index of the SH entry; empty: splat i has entry i
    std::vector<int8_t> sh;  // entries of shEntryBytes, coefficient-major, zero-padded; value = code · range of its band / 127

    std::vector<SplatGroup> groups;  // two per chunk; made by measureGroups, not in the file; empty: no level of detail

    uint32_t count() const { return uint32_t(place.size()); }
    uint64_t bytes() const {
        return chunks.size() * sizeof(SplatChunk) + parents.size() * 4 + parent.size() + (place.size() + size.size() + colour.size()) * 4 +
               shIndex.size() * 2 + sh.size() + groups.size() * sizeof(SplatGroup);
    }
};

}  // namespace dpl
