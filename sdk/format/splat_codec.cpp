#include "sdk/format/splat_codec.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string_view>
#include <unordered_map>

#include "sdk/format/plain_bytes.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr float kMinShRange = 1e-6f;   // below this a band is all zero
constexpr float kMaxScaleM = 1e3f, kMaxSh = 1e6f;

uint32_t encodeUv(float x) { return uint32_t(std::clamp(std::lround(double(x) * kUvSteps) + kUvZero, 0L, 2047L)); }
float decodeUv(uint32_t code) { return float((int(code) - kUvZero) / kUvSteps); }

// A covariance is the same at φ and φ + π.
uint32_t encodePhi(float phi) {
    const double turns = double(phi) / std::numbers::pi;
    return uint32_t(std::llround((turns - std::floor(turns)) * kPhiSteps)) % kPhiSteps;
}
float decodePhi(uint32_t code) { return float(code * std::numbers::pi / kPhiSteps); }

/** Codes 0..top between two attained values, evenly in `value` or in its logarithm. The ends decode exactly. */
class RangeCode {
public:
    RangeCode(float low, float high, uint32_t top, bool logarithmic) : low_(low), high_(high), top_(top), logarithmic_(logarithmic) {
        from_ = map(low), width_ = map(high) - from_;
    }
    float decode(uint32_t code) const {
        if (code == 0 || !(width_ > 0)) return low_;
        if (code >= top_) return high_;
        const double x = from_ + width_ * code / top_;
        return std::clamp(float(logarithmic_ ? std::exp(x) : x), low_, high_);
    }
    /** Nearest code, then moved until decode and nearest agree: in a range of a few ulps several codes decode alike, and the
     *  code must not change when the decoded value is encoded again. nearest∘decode is monotone, so this ends. */
    uint32_t encode(float value) const {
        uint32_t code = nearest(value);
        for (uint32_t round = 0; round < top_; ++round) {
            const uint32_t again = nearest(decode(code));
            if (again == code) break;
            code = again;
        }
        return code;
    }

private:
    double map(float v) const { return logarithmic_ ? std::log(double(v)) : double(v); }
    uint32_t nearest(float v) const {
        if (!(width_ > 0) || v <= low_) return 0;
        if (v >= high_) return top_;
        return uint32_t(std::clamp(std::llround((map(v) - from_) / width_ * top_), 0LL, (long long)top_));
    }
    float low_, high_;
    double from_, width_;
    uint32_t top_;
    bool logarithmic_;
};

float clampScale(float s) { return std::max(s, kMinSplatScaleM); }

int8_t encodeSh(float v, float range) { return range > 0 ? int8_t(std::lround(127.0 * v / range)) : int8_t(0); }
float decodeSh(int8_t code, float range) { return float(double(code) * range / 127.0); }

void appendVarint(std::vector<uint8_t>& out, uint32_t value) {
    for (; value >= 0x80; value >>= 7) out.push_back(uint8_t(value | 0x80));
    out.push_back(uint8_t(value));
}

/** Ranges of the chunk's splats; shRange is the caller's. */
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
            for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k) range[band - 1] = std::max(range[band - 1], std::abs(s.sh[size_t(i) * stride + k]));
        if (range[band - 1] < kMinShRange) range[band - 1] = 0;
    }
}

/** Codes of one splat's SH beyond coefficient 0. */
void codeShEntry(const float* sh, uint32_t degree, const float (&range)[3], int8_t* out) {
    for (uint32_t band = 1; band <= degree; ++band)
        for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k) out[k - 3] = encodeSh(sh[k], range[band - 1]);
}

/** Each different row of SH codes once, in order of first use, and which one a splat has. */
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
        if (known.size() > kMaxShPalette) return fail(Code::InvalidArgument, "more than {} different rows of SH for one palette; make them fewer first (paletteSh)", kMaxShPalette);
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
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) codeShEntry(s.sh.data() + size_t(i) * stride, s.shDegree, c.shRange, out.sh.data() + size_t(i) * entry);
    }
}

/** Splats [first, end) of each layer, in order; of a mesh whose layers do not tile its triangles (avatars made in memory may), all at once. */
template <class Visit>
void forLayers(const MeshData& mesh, const std::vector<uint32_t>& start, Visit&& visit) {
    uint32_t triangle = 0;
    for (const LayerData& layer : mesh.layers) {
        if (layer.firstTriangle != triangle || layer.triangleCount > mesh.triangles.size() - triangle) break;
        triangle += layer.triangleCount;
    }
    if (triangle != mesh.triangles.size()) return visit(start.front(), start.back());
    for (const LayerData& layer : mesh.layers) visit(start[layer.firstTriangle], start[layer.firstTriangle + layer.triangleCount]);
}

/** parents, parent and the chunks' firstParent, from the chunks' splats and the triangles'. */
void setParents(CodedSplats& out, const std::vector<uint32_t>& start) {
    const uint32_t n = out.count();
    out.parent.resize(n);
    uint32_t triangle = 0;
    size_t parents = 0;
    for (size_t t = 0; t + 1 < start.size(); ++t) parents += start[t] != start[t + 1];
    out.parents.reserve(parents + out.chunks.size());
    for (SplatChunk& c : out.chunks) {
        c.firstParent = uint32_t(out.parents.size());
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) {
            while (start[triangle + 1] <= i) ++triangle;
            if (out.parents.size() == c.firstParent || out.parents.back() != triangle) out.parents.push_back(triangle);
            out.parent[i] = uint8_t(out.parents.size() - 1 - c.firstParent);
        }
        c.firstTriangle = out.parents[c.firstParent], c.endTriangle = triangle + 1;
    }
}

/** Splats of each triangle, as a prefix sum. */
std::vector<uint32_t> triangleStarts(const CodedSplats& coded, size_t triangleCount) {
    std::vector<uint32_t> start(triangleCount + 1, 0);
    for (const SplatChunk& c : coded.chunks)
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) ++start[coded.parents[c.firstParent + coded.parent[i]] + 1];
    for (size_t t = 0; t < triangleCount; ++t) start[t + 1] += start[t];
    return start;
}

Result<std::vector<uint32_t>> decodeTriangleCounts(std::span<const uint8_t> bytes, uint32_t triangleCount, uint32_t splatCount) {
    if (bytes.size() < triangleCount) return fail(Code::CorruptData, "{} bytes of splat counts for {} triangles", bytes.size(), triangleCount);
    std::vector<uint32_t> start(size_t(triangleCount) + 1, 0);
    size_t at = 0;
    uint64_t total = 0;
    for (uint32_t t = 0; t < triangleCount; ++t) {
        uint64_t value = 0;
        for (uint32_t shift = 0;; shift += 7) {
            if (at == bytes.size() || shift > 28) return fail(Code::CorruptData, "splat count of triangle {} is cut off or too long", t);
            const uint8_t byte = bytes[at++];
            value |= uint64_t(byte & 0x7f) << shift;
            if (byte & 0x80) continue;
            if (byte == 0 && shift > 0) return fail(Code::CorruptData, "splat count of triangle {} is not in shortest form", t);
            break;
        }
        total += value;
        if (total > splatCount) return fail(Code::CorruptData, "triangles up to {} hold {} splats, the file has {}", t, total, splatCount);
        start[t + 1] = uint32_t(total);
    }
    if (total != splatCount) return fail(Code::CorruptData, "triangles hold {} splats, the file has {}", total, splatCount);
    if (at != bytes.size()) return fail(Code::CorruptData, "{} bytes after the last splat count", bytes.size() - at);
    return start;
}

Status checkChunk(const SplatChunk& c, size_t index, uint32_t first, uint32_t count, const std::vector<uint32_t>& start) {
    auto ordered = [](float low, float high, float limit) { return std::isfinite(low) && std::isfinite(high) && low <= high && std::abs(low) <= limit && std::abs(high) <= limit; };
    bool ok = c.firstSplat == first && c.splatCount == count && c.firstParent == 0;
    ok = ok && c.firstTriangle < c.endTriangle && c.endTriangle < start.size();
    ok = ok && start[c.firstTriangle] <= first && first < start[c.firstTriangle + 1];
    ok = ok && start[c.endTriangle - 1] < first + count && first + count <= start[c.endTriangle];
    if (!ok) return fail(Code::CorruptData, "chunk {} does not match the splat counts of its triangles", index);
    ok = ordered(c.scaleMinM, c.scaleMaxM, kMaxScaleM) && c.scaleMinM >= kMinSplatScaleM;
    for (int k = 0; k < 3; ++k) ok = ok && ordered(c.dcMin[k], c.dcMax[k], kMaxSh) && ordered(0, c.shRange[k], kMaxSh);
    if (!ok) return fail(Code::CorruptData, "chunk {} has a range that is not finite, empty or too large", index);
    return {};
}

uint32_t spread(uint32_t x) {   // 11 bits to every second bit
    x = (x | (x << 8)) & 0x00ff00ffu;
    x = (x | (x << 4)) & 0x0f0f0f0fu;
    x = (x | (x << 2)) & 0x33333333u;
    return (x | (x << 1)) & 0x55555555u;
}

}  // namespace

uint32_t splatMorton(const Vec2f& uv) { return spread(encodeUv(uv.x)) | (spread(encodeUv(uv.y)) << 1); }

Result<CodedSplats> codeSplats(const MeshData& mesh, const SplatData& s, bool shPalette) {
    CodedSplats out;
    const uint32_t n = s.count(), stride = shCoefficientCount(s.shDegree) * 3;
    out.shDegree = s.shDegree;
    if (n == 0) return out;
    out.place.reserve(n), out.size.reserve(n), out.colour.reserve(n);
    forLayers(mesh, s.triangleStart, [&](uint32_t layerFirst, uint32_t layerEnd) {
        for (uint32_t first = layerFirst; first < layerEnd; first += kSplatChunkSize) out.chunks.push_back(chunkRanges(s, first, std::min(kSplatChunkSize, layerEnd - first)));
    });
    for (const SplatChunk& c : out.chunks) {
        const RangeCode scale(c.scaleMinM, c.scaleMaxM, kScaleCodes, true);
        const RangeCode dc[3] = {{c.dcMin[0], c.dcMax[0], kColourCodes[0], false}, {c.dcMin[1], c.dcMax[1], kColourCodes[1], false}, {c.dcMin[2], c.dcMax[2], kColourCodes[2], false}};
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) {
            out.place.push_back(encodeUv(s.uv[i].x) | encodeUv(s.uv[i].y) << 11 | encodePhi(s.phi[i]) << 22);
            const uint32_t opacity = uint32_t(std::lround(std::clamp(s.opacity[i], 0.0f, 1.0f) * 255.0));
            out.size.push_back(scale.encode(clampScale(s.scaleM[i].x)) | scale.encode(clampScale(s.scaleM[i].y)) << 11 | opacity << 22 |
                               uint32_t(bool(s.flags[i] & kSplatSingleFace)) << 30 | uint32_t(bool(s.flags[i] & kSplatCloth)) << 31);
            const float* sh = s.sh.data() + size_t(i) * stride;
            out.colour.push_back(dc[0].encode(sh[0]) | dc[1].encode(sh[1]) << 10 | dc[2].encode(sh[2]) << 21);
        }
    }
    setParents(out, s.triangleStart);
    if (s.shDegree > 0) {
        if (shPalette) { DPL_CHECK_OK(codeShPalette(s, out)); }
        else codeShOfEachSplat(s, out);
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
        const RangeCode dc[3] = {{c.dcMin[0], c.dcMax[0], kColourCodes[0], false}, {c.dcMin[1], c.dcMax[1], kColourCodes[1], false}, {c.dcMin[2], c.dcMax[2], kColourCodes[2], false}};
        for (uint32_t i = c.firstSplat; i < c.firstSplat + c.splatCount; ++i) {
            const uint32_t place = in.place[i], size = in.size[i], colour = in.colour[i];
            s.uv[i] = {decodeUv(place & 2047), decodeUv(place >> 11 & 2047)};
            s.phi[i] = decodePhi(place >> 22);
            s.scaleM[i] = {scale.decode(size & 2047), scale.decode(size >> 11 & 2047)};
            s.opacity[i] = float((size >> 22 & 255) / 255.0);
            s.flags[i] = uint8_t((size >> 30 & 1 ? kSplatSingleFace : 0) | (size >> 31 & 1 ? kSplatCloth : 0));
            float* sh = s.sh.data() + size_t(i) * stride;
            sh[0] = dc[0].decode(colour & 1023), sh[1] = dc[1].decode(colour >> 10 & 2047), sh[2] = dc[2].decode(colour >> 21);
            const int8_t* rest = in.sh.data() + size_t(in.shIndex.empty() ? i : in.shIndex[i]) * entry;
            for (uint32_t band = 1; band <= in.shDegree; ++band)
                for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k) sh[k] = decodeSh(rest[k - 3], c.shRange[band - 1]);
        }
    }
    return s;
}

SplatStreams<std::vector<uint8_t>> writeSplatStreams(const CodedSplats& coded, size_t triangleCount) {
    SplatStreams<std::vector<uint8_t>> out;
    const std::vector<uint32_t> start = triangleStarts(coded, triangleCount);
    for (size_t t = 0; t < triangleCount; ++t) appendVarint(out.triangleCounts, start[t + 1] - start[t]);
    std::vector<SplatChunk> chunks = coded.chunks;
    for (SplatChunk& c : chunks) c.firstParent = 0;
    out.chunks = bytesOf(chunks), out.place = bytesOf(coded.place), out.size = bytesOf(coded.size), out.colour = bytesOf(coded.colour), out.shIndex = bytesOf(coded.shIndex);
    const uint32_t inMemory = shEntryBytes(coded.shDegree), inFile = (shCoefficientCount(coded.shDegree) - 1) * 3;
    for (size_t at = 0; at < coded.sh.size(); at += inMemory) out.sh.insert(out.sh.end(), coded.sh.begin() + ptrdiff_t(at), coded.sh.begin() + ptrdiff_t(at + inFile));
    return out;
}

Result<CodedSplats> readSplatStreams(const SplatStreams<std::span<const uint8_t>>& in, const MeshData& mesh, const SplatHead& head, const ReadLimits& limits) {
    const uint32_t n = head.count, entries = head.paletteSize ? head.paletteSize : n;
    if (n > limits.maxSplats) return fail(Code::CorruptData, "{} splats, the limit is {}", n, limits.maxSplats);
    if (head.shDegree > kMaxShDegree) return fail(Code::CorruptData, "SH degree {}, at most {} is possible", head.shDegree, kMaxShDegree);
    if (head.paletteSize > kMaxShPalette || (head.paletteSize && (n == 0 || head.shDegree == 0)))
        return fail(Code::CorruptData, "an SH palette of {} entries for {} splats of SH degree {}", head.paletteSize, n, head.shDegree);
    const uint32_t inFile = (shCoefficientCount(head.shDegree) - 1) * 3, inMemory = shEntryBytes(head.shDegree);
    if (in.place.size() != size_t(n) * 4 || in.size.size() != size_t(n) * 4 || in.colour.size() != size_t(n) * 4 || in.sh.size() != size_t(entries) * inFile ||
        in.shIndex.size() != (head.paletteSize ? size_t(n) * 2 : 0))
        return fail(Code::CorruptData, "splat streams of {}, {}, {}, {} and {} bytes do not hold {} splats and {} rows of SH", in.place.size(), in.size.size(), in.colour.size(), in.shIndex.size(), in.sh.size(), n, entries);
    DPL_TRY(const std::vector<uint32_t> start, decodeTriangleCounts(in.triangleCounts, uint32_t(mesh.triangles.size()), n));
    size_t chunkCount = 0;
    forLayers(mesh, start, [&](uint32_t first, uint32_t end) { chunkCount += (end - first + kSplatChunkSize - 1) / kSplatChunkSize; });
    if (in.chunks.size() != chunkCount * sizeof(SplatChunk)) return fail(Code::CorruptData, "{} bytes of chunk records, {} chunks expected", in.chunks.size(), chunkCount);

    CodedSplats out;
    out.shDegree = head.shDegree;
    fill(out.chunks, in.chunks), fill(out.place, in.place), fill(out.size, in.size), fill(out.colour, in.colour), fill(out.shIndex, in.shIndex);
    out.sh.resize(inFile ? size_t(entries) * inMemory : 0);
    for (size_t e = 0; inFile && e < entries; ++e) {
        std::memcpy(out.sh.data() + e * inMemory, in.sh.data() + e * inFile, inFile);
        // −128 is no code: a writer never makes it, and a range would not be attained.
        if (std::find(out.sh.begin() + ptrdiff_t(e * inMemory), out.sh.begin() + ptrdiff_t(e * inMemory + inFile), int8_t(-128)) != out.sh.begin() + ptrdiff_t(e * inMemory + inFile))
            return fail(Code::CorruptData, "row {} of SH holds a code of -128", e);
    }
    for (size_t i = 0; i < out.shIndex.size(); ++i)
        if (out.shIndex[i] >= entries) return fail(Code::CorruptData, "splat {} has SH entry {} of {}", i, out.shIndex[i], entries);
    Status chunksFit;
    size_t index = 0;
    forLayers(mesh, start, [&](uint32_t layerFirst, uint32_t layerEnd) {
        for (uint32_t first = layerFirst; first < layerEnd && chunksFit; first += kSplatChunkSize, ++index) {
            chunksFit = checkChunk(out.chunks[index], index, first, std::min(kSplatChunkSize, layerEnd - first), start);
            if (chunksFit && head.paletteSize && !std::equal(out.chunks[index].shRange, out.chunks[index].shRange + 3, out.chunks[0].shRange))
                chunksFit = fail(Code::CorruptData, "chunk {} has another range of SH than the palette", index);
        }
    });
    DPL_CHECK_OK(chunksFit);
    setParents(out, start);
    return out;
}

}  // namespace dpl
