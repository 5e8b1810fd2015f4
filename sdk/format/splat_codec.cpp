// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/splat_codec.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <unordered_map>

#include "sdk/format/range_code.h"
#include "sdk/format/splat_chunks.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr float kMinShRange = 1e-6f;  // below this a band is all zero

uint32_t encodeUv(float x) {
    return uint32_t(std::clamp(std::lround(double(x) * kUvSteps) + kUvZero, 0L, 2047L));
}
float decodeUv(uint32_t code) {
    return float((int(code) - kUvZero) / kUvSteps);
}

// φ and φ + π give the same covariance.
uint32_t encodePhi(float phi) {
    const double turns = double(phi) / std::numbers::pi;
    return uint32_t(std::llround((turns - std::floor(turns)) * kPhiSteps)) % kPhiSteps;
}
float decodePhi(uint32_t code) {
    return float(code * std::numbers::pi / kPhiSteps);
}

float clampScale(float s) {
    return std::max(s, kMinSplatScaleM);
}

int8_t encodeSh(float v, float range) {
    return range > 0 ? int8_t(std::lround(127.0 * v / range)) : int8_t(0);
}
float decodeSh(int8_t code, float range) {
    return float(double(code) * range / 127.0);
}

/** The chunk of these splats with its ranges. The caller sets shRange. */
SplatChunk chunkRanges(const SplatData& s, uint32_t first, uint32_t count) {
    const uint32_t stride = shCoefficientCount(s.shDegree) * 3;
    SplatChunk c;
    c.firstSplat = first, c.splatCount = count;
    for (uint32_t i = first; i < first + count; ++i) {
        const bool start = i == first;
        const float a = clampScale(s.scaleM[i].x), b = clampScale(s.scaleM[i].y);
        c.scaleMinM = start ? std::min(a, b) : std::min({c.scaleMinM, a, b});
        c.scaleMaxM = std::max({c.scaleMaxM, a, b});
        const float* sh = s.sh.data() + size_t(i) * stride;
        for (int k = 0; k < 3; ++k) {
            c.dcMin[k] = start ? sh[k] : std::min(c.dcMin[k], sh[k]);
            c.dcMax[k] = start ? sh[k] : std::max(c.dcMax[k], sh[k]);
        }
    }
    return c;
}

/** Largest magnitude of bands 1, 2, 3 over splats [first, first + count). */
void shRanges(const SplatData& s, uint32_t first, uint32_t count, float (&range)[3]) {
    const uint32_t stride = shCoefficientCount(s.shDegree) * 3;
    std::fill(range, range + 3, 0.0f);
    for (uint32_t band = 1; band <= s.shDegree; ++band) {
        for (uint32_t i = first; i < first + count; ++i)
            for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k)
                range[band - 1] = std::max(range[band - 1], std::abs(s.sh[size_t(i) * stride + k]));
        if (range[band - 1] < kMinShRange) range[band - 1] = 0;
    }
}

/** Codes the SH of one splat beyond coefficient 0. */
void codeShEntry(const float* sh, uint32_t degree, const float (&range)[3], int8_t* out) {
    for (uint32_t band = 1; band <= degree; ++band)
        for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k) out[k - 3] = encodeSh(sh[k], range[band - 1]);
}

/** Stores each different row of SH codes once, in order of first use, and the index of each splat's row. */
Status codeShPalette(const SplatData& s, CodedSplats& out) {
    const uint32_t n = s.count(), stride = shCoefficientCount(s.shDegree) * 3, entry = shEntryBytes(s.shDegree);
    float range[3];
    shRanges(s, 0, n, range);
    std::unordered_map<std::string, uint32_t> known;
    std::string row(entry, '\0');
    out.shIndex.resize(n);
    for (uint32_t i = 0; i < n; ++i) {
        codeShEntry(s.sh.data() + size_t(i) * stride, s.shDegree, range, reinterpret_cast<int8_t*>(row.data()));
        const auto [at, added] = known.try_emplace(row, uint32_t(known.size()));
        if (known.size() > kMaxShPalette)
            return fail(Code::InvalidArgument, "more than {} different rows of SH for one palette; make them fewer first (paletteSh)",
                        kMaxShPalette);
        out.shIndex[i] = uint16_t(at->second);
        if (added) out.sh.insert(out.sh.end(), row.begin(), row.end());
    }
    for (SplatChunk& c : out.chunks) std::copy(range, range + 3, c.shRange);
    return {};
}

void codeShOfEachSplat(const SplatData& s, CodedSplats& out) {
    const uint32_t stride = shCoefficientCount(s.shDegree) * 3, entry = shEntryBytes(s.shDegree);
    out.sh.assign(size_t(s.count()) * entry, 0);
    for (SplatChunk& c : out.chunks) {
        shRanges(s, c.firstSplat, c.splatCount, c.shRange);
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i)
            codeShEntry(s.sh.data() + size_t(i) * stride, s.shDegree, c.shRange, out.sh.data() + size_t(i) * entry);
    }
}

uint32_t spread(uint32_t x) {  // moves bit k to bit 2k, for 11 bits
    x = (x | (x << 8)) & 0x00ff00ffu;
    x = (x | (x << 4)) & 0x0f0f0f0fu;
    x = (x | (x << 2)) & 0x33333333u;
    return (x | (x << 1)) & 0x55555555u;
}

}  // namespace

uint32_t splatMorton(const Vec2f& uv) {
    return spread(encodeUv(uv.x)) | (spread(encodeUv(uv.y)) << 1);
}

Result<CodedSplats> codeSplats(const MeshData& mesh, const SplatData& s, bool shPalette) {
    CodedSplats out;
    const uint32_t n = s.count(), stride = shCoefficientCount(s.shDegree) * 3;
    out.shDegree = s.shDegree;
    if (n == 0) return out;
    out.place.reserve(n), out.size.reserve(n), out.colour.reserve(n);
    forChunks(mesh, s.triangleStart, [&](uint32_t first, uint32_t count) { out.chunks.push_back(chunkRanges(s, first, count)); });
    for (const SplatChunk& c : out.chunks) {
        const RangeCode scale(c.scaleMinM, c.scaleMaxM, kScaleCodes, true);
        const RangeCode dc[3] = {{c.dcMin[0], c.dcMax[0], kColourCodes[0], false},
                                 {c.dcMin[1], c.dcMax[1], kColourCodes[1], false},
                                 {c.dcMin[2], c.dcMax[2], kColourCodes[2], false}};
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) {
            out.place.push_back(encodeUv(s.uv[i].x) | encodeUv(s.uv[i].y) << 11 | encodePhi(s.phi[i]) << 22);
            const uint32_t opacity = uint32_t(std::lround(std::clamp(s.opacity[i], 0.0f, 1.0f) * 255.0));
            out.size.push_back(scale.encode(clampScale(s.scaleM[i].x)) | scale.encode(clampScale(s.scaleM[i].y)) << 11 | opacity << 22 |
                               (s.flags[i] & kSplatSingleFace ? kSingleFaceBit : 0) | uint32_t(bool(s.flags[i] & kSplatCloth)) << 31);
            const float* sh = s.sh.data() + size_t(i) * stride;
            out.colour.push_back(dc[0].encode(sh[0]) | dc[1].encode(sh[1]) << 10 | dc[2].encode(sh[2]) << 21);
        }
    }
    setParents(out, s.triangleStart);
    if (s.shDegree > 0) {
        if (shPalette) {
            DPL_RETURN_IF_ERROR(codeShPalette(s, out));
        } else
            codeShOfEachSplat(s, out);
    }
    return out;
}

SplatData decodeSplats(const CodedSplats& in, size_t triangleCount) {
    SplatData s;
    const uint32_t n = in.count(), stride = shCoefficientCount(in.shDegree) * 3, entry = shEntryBytes(in.shDegree);
    s.shDegree = in.shDegree;
    s.triangleStart = triangleStarts(in, triangleCount);
    s.uv.resize(n), s.phi.resize(n), s.scaleM.resize(n), s.opacity.resize(n), s.flags.resize(n), s.sh.resize(size_t(n) * stride);
    for (const SplatChunk& c : in.chunks) {
        const RangeCode scale(c.scaleMinM, c.scaleMaxM, kScaleCodes, true);
        const RangeCode dc[3] = {{c.dcMin[0], c.dcMax[0], kColourCodes[0], false},
                                 {c.dcMin[1], c.dcMax[1], kColourCodes[1], false},
                                 {c.dcMin[2], c.dcMax[2], kColourCodes[2], false}};
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) {
            const uint32_t place = in.place[i], size = in.size[i], colour = in.colour[i];
            s.uv[i] = {decodeUv(place & 2047), decodeUv(place >> 11 & 2047)};
            s.phi[i] = decodePhi(place >> 22);
            s.scaleM[i] = {scale.decode(size & 2047), scale.decode(size >> 11 & 2047)};
            s.opacity[i] = float((size >> 22 & 255) / 255.0);
            s.flags[i] = uint8_t((size & kSingleFaceBit ? kSplatSingleFace : 0) | (size >> 31 & 1 ? kSplatCloth : 0));
            float* sh = s.sh.data() + size_t(i) * stride;
            sh[0] = dc[0].decode(colour & 1023), sh[1] = dc[1].decode(colour >> 10 & 2047), sh[2] = dc[2].decode(colour >> 21);
            const int8_t* rest = in.sh.data() + size_t(in.shIndex.empty() ? i : in.shIndex[i]) * entry;
            for (uint32_t band = 1; band <= in.shDegree; ++band)
                for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k) sh[k] = decodeSh(rest[k - 3], c.shRange[band - 1]);
        }
    }
    return s;
}

}  // namespace dpl
