#include "sdk/format/splat_codec.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "sdk/format/avatar_file.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

// u and v have 11 bits: 0 and 1 are exact, and a splat may overshoot its triangle by 6 %.
constexpr int kUvZero = 113;
constexpr double kUvSteps = 1820;
constexpr uint32_t kPhiSteps = 1024;
constexpr uint32_t kScaleMax = 2047;
constexpr uint32_t kColourMax[3] = {1023, 2047, 2047};
constexpr float kMinShRange = 1e-6f;   // below this a band of a chunk is all zero
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

template <class T>
void appendValue(std::vector<uint8_t>& out, const T& value) {
    const auto* raw = reinterpret_cast<const uint8_t*>(&value);
    out.insert(out.end(), raw, raw + sizeof(T));
}

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
        for (uint32_t band = 1; band <= s.shDegree; ++band)
            for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k) c.shRange[band - 1] = std::max(c.shRange[band - 1], std::abs(sh[k]));
    }
    for (float& range : c.shRange)
        if (range < kMinShRange) range = 0;
    return c;
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
    bool ok = c.firstSplat == first && c.splatCount == count && c.pad0 == 0;
    ok = ok && c.firstTriangle < c.endTriangle && c.endTriangle < start.size();
    ok = ok && start[c.firstTriangle] <= first && first < start[c.firstTriangle + 1];
    ok = ok && start[c.endTriangle - 1] < first + count && first + count <= start[c.endTriangle];
    if (!ok) return fail(Code::CorruptData, "chunk {} does not match the splat counts of its triangles", index);
    ok = ordered(c.scaleMinM, c.scaleMaxM, kMaxScaleM) && c.scaleMinM >= kMinSplatScaleM;
    for (int k = 0; k < 3; ++k) ok = ok && ordered(c.dcMin[k], c.dcMax[k], kMaxSh) && ordered(0, c.shRange[k], kMaxSh);
    if (!ok) return fail(Code::CorruptData, "chunk {} has a range that is not finite, empty or too large", index);
    return {};
}

uint32_t wordAt(std::span<const uint8_t> bytes, size_t index) {
    uint32_t w;
    std::memcpy(&w, bytes.data() + index * 4, 4);
    return w;
}

uint32_t spread(uint32_t x) {   // 11 bits to every second bit
    x = (x | (x << 8)) & 0x00ff00ffu;
    x = (x | (x << 4)) & 0x0f0f0f0fu;
    x = (x | (x << 2)) & 0x33333333u;
    return (x | (x << 1)) & 0x55555555u;
}

}  // namespace

uint32_t splatMorton(const Vec2f& uv) { return spread(encodeUv(uv.x)) | (spread(encodeUv(uv.y)) << 1); }

SplatStreams<std::vector<uint8_t>> encodeSplats(const MeshData& mesh, const SplatData& s) {
    SplatStreams<std::vector<uint8_t>> out;
    const uint32_t n = s.count(), stride = shCoefficientCount(s.shDegree) * 3;
    out.place.reserve(size_t(n) * 4), out.size.reserve(size_t(n) * 4), out.colour.reserve(size_t(n) * 4), out.sh.reserve(size_t(n) * (stride - 3));
    for (size_t t = 0; t + 1 < s.triangleStart.size(); ++t) appendVarint(out.triangleCounts, s.triangleStart[t + 1] - s.triangleStart[t]);

    uint32_t triangle = 0;
    for (const LayerData& layer : mesh.layers) {
        const uint32_t layerEnd = s.triangleStart[layer.firstTriangle + layer.triangleCount];
        for (uint32_t first = s.triangleStart[layer.firstTriangle]; first < layerEnd; first += kSplatChunkSize) {
            const uint32_t count = std::min(kSplatChunkSize, layerEnd - first);
            SplatChunk c = chunkRanges(s, first, count);
            while (s.triangleStart[triangle + 1] <= first) ++triangle;
            c.firstTriangle = triangle;
            while (s.triangleStart[triangle + 1] < first + count) ++triangle;
            c.endTriangle = triangle + 1;
            appendValue(out.chunks, c);

            const RangeCode scale(c.scaleMinM, c.scaleMaxM, kScaleMax, true);
            const RangeCode dc[3] = {{c.dcMin[0], c.dcMax[0], kColourMax[0], false}, {c.dcMin[1], c.dcMax[1], kColourMax[1], false}, {c.dcMin[2], c.dcMax[2], kColourMax[2], false}};
            for (uint32_t i = first; i < first + count; ++i) {
                appendValue(out.place, encodeUv(s.uv[i].x) | encodeUv(s.uv[i].y) << 11 | encodePhi(s.phi[i]) << 22);
                const uint32_t opacity = uint32_t(std::lround(std::clamp(s.opacity[i], 0.0f, 1.0f) * 255.0));
                appendValue(out.size, scale.encode(clampScale(s.scaleM[i].x)) | scale.encode(clampScale(s.scaleM[i].y)) << 11 | opacity << 22 |
                                          uint32_t(bool(s.flags[i] & kSplatSingleFace)) << 30 | uint32_t(bool(s.flags[i] & kSplatCloth)) << 31);
                const float* sh = s.sh.data() + size_t(i) * stride;
                appendValue(out.colour, dc[0].encode(sh[0]) | dc[1].encode(sh[1]) << 10 | dc[2].encode(sh[2]) << 21);
                for (uint32_t band = 1; band <= s.shDegree; ++band)
                    for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k) out.sh.push_back(uint8_t(encodeSh(sh[k], c.shRange[band - 1])));
            }
        }
    }
    return out;
}

Result<SplatData> decodeSplats(const SplatStreams<std::span<const uint8_t>>& in, const MeshData& mesh, uint32_t n, uint32_t shDegree, const ReadLimits& limits) {
    if (n > limits.maxSplats) return fail(Code::CorruptData, "{} splats, the limit is {}", n, limits.maxSplats);
    if (shDegree > kMaxShDegree) return fail(Code::CorruptData, "SH degree {}, at most {} is possible", shDegree, kMaxShDegree);
    const uint32_t stride = shCoefficientCount(shDegree) * 3;
    if (in.place.size() != size_t(n) * 4 || in.size.size() != size_t(n) * 4 || in.colour.size() != size_t(n) * 4 || in.sh.size() != size_t(n) * (stride - 3))
        return fail(Code::CorruptData, "splat streams of {}, {}, {} and {} bytes do not hold {} splats", in.place.size(), in.size.size(), in.colour.size(), in.sh.size(), n);
    SplatData s;
    DPL_TRY(s.triangleStart, decodeTriangleCounts(in.triangleCounts, uint32_t(mesh.triangles.size()), n));
    size_t chunkCount = 0;
    for (const LayerData& layer : mesh.layers)
        chunkCount += (s.triangleStart[layer.firstTriangle + layer.triangleCount] - s.triangleStart[layer.firstTriangle] + kSplatChunkSize - 1) / kSplatChunkSize;
    if (in.chunks.size() != chunkCount * sizeof(SplatChunk)) return fail(Code::CorruptData, "{} bytes of chunk records, {} chunks expected", in.chunks.size(), chunkCount);

    s.shDegree = shDegree;
    s.uv.resize(n), s.phi.resize(n), s.scaleM.resize(n), s.opacity.resize(n), s.flags.resize(n), s.sh.resize(size_t(n) * stride);
    size_t chunkIndex = 0;
    for (const LayerData& layer : mesh.layers) {
        const uint32_t layerEnd = s.triangleStart[layer.firstTriangle + layer.triangleCount];
        for (uint32_t first = s.triangleStart[layer.firstTriangle]; first < layerEnd; first += kSplatChunkSize, ++chunkIndex) {
            const uint32_t count = std::min(kSplatChunkSize, layerEnd - first);
            SplatChunk c;
            std::memcpy(&c, in.chunks.data() + chunkIndex * sizeof(SplatChunk), sizeof(SplatChunk));
            DPL_CHECK_OK(checkChunk(c, chunkIndex, first, count, s.triangleStart));
            const RangeCode scale(c.scaleMinM, c.scaleMaxM, kScaleMax, true);
            const RangeCode dc[3] = {{c.dcMin[0], c.dcMax[0], kColourMax[0], false}, {c.dcMin[1], c.dcMax[1], kColourMax[1], false}, {c.dcMin[2], c.dcMax[2], kColourMax[2], false}};
            for (uint32_t i = first; i < first + count; ++i) {
                const uint32_t place = wordAt(in.place, i), size = wordAt(in.size, i), colour = wordAt(in.colour, i);
                s.uv[i] = {decodeUv(place & 2047), decodeUv(place >> 11 & 2047)};
                s.phi[i] = decodePhi(place >> 22);
                s.scaleM[i] = {scale.decode(size & 2047), scale.decode(size >> 11 & 2047)};
                s.opacity[i] = float((size >> 22 & 255) / 255.0);
                s.flags[i] = uint8_t((size >> 30 & 1 ? kSplatSingleFace : 0) | (size >> 31 & 1 ? kSplatCloth : 0));
                float* sh = s.sh.data() + size_t(i) * stride;
                sh[0] = dc[0].decode(colour & 1023), sh[1] = dc[1].decode(colour >> 10 & 2047), sh[2] = dc[2].decode(colour >> 21);
                const uint8_t* rest = in.sh.data() + size_t(i) * (stride - 3);
                for (uint32_t band = 1; band <= shDegree; ++band)
                    for (uint32_t k = band * band * 3; k < (band + 1) * (band + 1) * 3; ++k) sh[k] = decodeSh(int8_t(rest[k - 3]), c.shRange[band - 1]);
            }
        }
    }
    return s;
}

}  // namespace dpl
