// SPDX-License-Identifier: Apache-2.0
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sdk/core/task.h"
#include "sdk/core/writer.h"
#include "sdk/format/spz.h"
#include "sdk/format/spz_layout.h"

namespace dpl {
namespace {

using namespace spz;

constexpr int32_t kLargestCode = 8388607;  // of a coordinate, 24 bits with a sign
constexpr uint32_t kUsualFractionalBits = 12;
constexpr int kZstdLevel = 12;
using Bytes = std::vector<uint8_t>;

uint8_t code8(double value) {
    return uint8_t(std::lround(std::clamp(value, 0.0, 255.0)));
}

/** 12 bits after the point hold 0.2 mm. A scene within a metre gets as many more as keep its places as fine against its size; a scene
 *  beyond 2 km fewer. */
Result<uint32_t> fractionalBitsFor(float largestM) {
    if (largestM > float(kLargestCode))
        return fail(Code::Unsupported, "a splat lies at {} m; SPZ holds ±{} m; export a .glb, or move the scene", largestM, kLargestCode);
    uint32_t bits = kUsualFractionalBits;
    while (bits > 0 && double(largestM) * (1u << bits) > kLargestCode) --bits;
    while (bits < kMaxFractionalBits && bits >= kUsualFractionalBits && double(largestM) * (1u << (bits - kUsualFractionalBits + 1)) < 1)
        ++bits;
    return bits;
}

/** The largest of x, y, z, w is left out; two bits name it. The others take a sign and 9 bits of 1/√2 each, the last in the lowest bits. */
uint32_t smallestThree(const Quatf& given) {
    const Quatf unit = glm::normalize(given);
    const float q[4] = {unit.x, unit.y, unit.z, unit.w};
    uint32_t largest = 0;
    for (uint32_t k = 1; k < 4; ++k)
        if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
    const bool negate = q[largest] < 0;  // the one that is left out is read as positive
    uint32_t word = largest;
    for (uint32_t k = 0; k < 4; ++k) {
        if (k == largest) continue;
        const long magnitude = std::min(511l, std::lround(std::abs(double(q[k])) * std::sqrt(2.0) * 511));
        word = word << 10 | uint32_t((q[k] < 0) != negate) << 9 | uint32_t(magnitude);
    }
    return word;
}

Status check(const StaticSplatData& s, uint32_t version) {
    const size_t n = s.position.size();
    if (version != 3 && version != 4) return fail(Code::InvalidArgument, "SPZ version {}; 3 and 4 are written", version);
    if (n == 0 || n > std::numeric_limits<uint32_t>::max()) return fail(Code::InvalidArgument, "{} splats for an SPZ file", n);
    if (s.shDegree > kMaxShDegree || s.rotation.size() != n || s.scaleM.size() != n || s.opacity.size() != n ||
        s.sh.size() != n * shCoefficientCount(s.shDegree) * 3)
        return fail(Code::InvalidArgument, "the arrays of {} splats differ in length", n);
    for (size_t i = 0; i < n; ++i) {
        const Vec3f all = s.position[i] + s.scaleM[i];
        if (!std::isfinite(all.x + all.y + all.z + s.opacity[i]) || !(glm::length(s.rotation[i]) > 1e-6f))
            return fail(Code::InvalidArgument, "splat {} has a number that is not finite, or no rotation", i);
    }
    for (const float v : s.sh)
        if (!std::isfinite(v)) return fail(Code::InvalidArgument, "an SH value is not finite");
    return {};
}

std::array<Bytes, kAttributes> attributesOf(const StaticSplatData& s, uint32_t fractionalBits) {
    std::array<Bytes, kAttributes> out;
    auto& [place, alpha, colour, scale, rotation, rest] = out;
    const uint32_t coefficients = shCoefficientCount(s.shDegree);
    const double steps = double(1u << fractionalBits);
    for (size_t i = 0; i < s.position.size(); ++i) {
        const float* sh = s.sh.data() + i * coefficients * 3;
        for (int k = 0; k < 3; ++k) {
            const long at = std::lround(std::clamp(s.position[i][k] * steps, -double(kLargestCode), double(kLargestCode)));
            for (int byte = 0; byte < 3; ++byte) place.push_back(uint8_t(uint64_t(at) >> (8 * byte)));
            scale.push_back(code8((std::log(std::max(double(s.scaleM[i][k]), 1e-9)) + 10) * 16));
            colour.push_back(code8((sh[k] * 0.15 + 0.5) * 255));
        }
        alpha.push_back(code8(double(s.opacity[i]) * 255));
        const uint32_t word = smallestThree(s.rotation[i]);
        for (int byte = 0; byte < 4; ++byte) rotation.push_back(uint8_t(word >> (8 * byte)));
        for (uint32_t k = 3; k < coefficients * 3; ++k) rest.push_back(code8(sh[k] * 128.0 + 128));
    }
    return out;
}

Result<Bytes> gzipped(std::span<const uint8_t> bytes) {
    z_stream stream{};
    if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return outOfMemory("write an SPZ file");
    Bytes out, piece(1 << 16);
    constexpr size_t kMost = 1u << 30;  // zlib counts in 32 bits
    for (size_t at = 0; true;) {
        const size_t given = std::min(bytes.size() - at, kMost);
        stream.next_in = const_cast<Bytef*>(bytes.data() + at), stream.avail_in = uInt(given);
        stream.next_out = piece.data(), stream.avail_out = uInt(piece.size());
        const int result = deflate(&stream, at + given == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
        at += given - stream.avail_in;
        out.insert(out.end(), piece.begin(), piece.end() - ptrdiff_t(stream.avail_out));
        if (result == Z_STREAM_END) break;
    }
    deflateEnd(&stream);
    return out;
}

}  // namespace

Result<std::vector<uint8_t>> writeSpz(const StaticSplatData& s, uint32_t version) try {
    DPL_RETURN_IF_ERROR(check(s, version));
    float largestM = 0;
    for (const Vec3f& p : s.position) largestM = std::max({largestM, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    DPL_TRY(const uint32_t fractionalBits, fractionalBitsFor(largestM));
    const auto attributes = attributesOf(s, fractionalBits);
    const auto stored = std::count_if(attributes.begin(), attributes.end(), [](const Bytes& a) { return !a.empty(); });
    const Header header{kMagic,
                        version,
                        uint32_t(s.position.size()),
                        uint8_t(s.shDegree),
                        uint8_t(fractionalBits),
                        s.compensated ? kAntialiasedFlag : uint8_t(0),
                        version == 4 ? uint8_t(stored) : uint8_t(0)};
    Writer out;
    out.value(header);
    if (version == 3) {
        for (const Bytes& a : attributes) out.append(a);
        return gzipped(out.finish());
    }
    out.value(uint32_t(kHeader4Bytes));
    out.append(Bytes(12, 0));
    std::vector<Bytes> streams;
    for (const Bytes& a : attributes) {
        if (a.empty()) continue;
        Bytes packed(ZSTD_compressBound(a.size()));
        const size_t bytes = ZSTD_compress(packed.data(), packed.size(), a.data(), a.size(), kZstdLevel);
        if (ZSTD_isError(bytes)) return fail(Code::Internal, "the splats could not be compressed: {}", ZSTD_getErrorName(bytes));
        packed.resize(bytes);
        out.value(uint64_t(bytes)), out.value(uint64_t(a.size()));
        streams.push_back(std::move(packed));
    }
    for (const Bytes& packed : streams) out.append(packed);
    return out.finish();
} catch (const std::bad_alloc&) {
    return outOfMemory("write an SPZ file");
}

}  // namespace dpl
