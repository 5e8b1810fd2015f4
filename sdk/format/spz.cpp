// SPDX-License-Identifier: Apache-2.0
// Packed attributes of n splats, as consecutive arrays (versions 2 and 3) or as one stream each (version 4):
//
//   position 9n (3 × s24 fixed point) | alpha n | colour 3n | log scale 3n | rotation 3n or 4n | SH of bands 1.. 3·coefficients·n
#include "sdk/format/spz.h"

#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "sdk/core/reader.h"
#include "sdk/core/task.h"
#include "sdk/format/read_limits.h"
#include "sdk/format/spz_layout.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

using namespace spz;

constexpr uint32_t kFileShDegrees = 4;  // of the format; Doppel draws up to kMaxShDegree
constexpr uint64_t kFreeExpansionBytes = 1 << 20, kMaxExtensionBytes = 1 << 20;
constexpr uint32_t kCoordinateExtension = 0xadbe0003;  // by Adobe: one u32, the axes

struct Packed {
    Header header;
    std::array<std::vector<uint8_t>, kAttributes> attributes;
    std::vector<uint8_t> extensions;  // records of u32 type, u32 bytes, and as many bytes
};

/** Axes by their number in the coordinate extension. */
constexpr std::array<const char*, 16> kCoordinateSystems = {"LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF",
                                                            "LFD", "RFD", "LFU", "RFU", "LBD", "RBD", "LBU", "RBU"};

/** The axes that the extensions state, else those of the format. Records that are cut off end the list, as in other readers. */
SplatAxes axesOf(std::span<const uint8_t> extensions, std::vector<std::string>& notes) {
    SplatAxes axes = *axesOfLetters("RUB");
    for (Reader in(extensions); in.remaining() >= 8;) {
        const uint32_t type = *in.u32(), size = *in.u32();
        const auto record = in.take(size);
        if (!record) break;
        if (type != kCoordinateExtension || record->size() < 4) continue;
        uint32_t number;
        std::memcpy(&number, record->data(), 4);
        if (number >= 1 && number <= kCoordinateSystems.size())
            axes = *axesOfLetters(kCoordinateSystems[number - 1]);
        else if (number != 0)  // 0: not specified
            notes.push_back(
                formatText("coordinate system {} of the extension is unknown (1 to 16 are defined); read as right, up, back", number));
    }
    return axes;
}

Status checkHeader(const Header& h, size_t fileBytes) {
    if (h.magic != kMagic) return fail(Code::Unsupported, "not an SPZ file: its header does not say NGSP");
    if (h.version < kMinSpzVersion || h.version > kMaxSpzVersion)
        return fail(Code::Version, "SPZ version {}; this build reads {} to {}: {}", h.version, kMinSpzVersion, kMaxSpzVersion,
                    h.version > kMaxSpzVersion ? "update Doppel" : "save it again with a newer tool");
    if (h.shDegree > kFileShDegrees)
        return fail(Code::CorruptData, "SPZ: SH degree {}, 0 to {} are possible", uint32_t(h.shDegree), kFileShDegrees);
    if (h.fractionalBits > kMaxFractionalBits)
        return fail(Code::CorruptData, "SPZ: {} fractional bits in a position of 24", uint32_t(h.fractionalBits));
    if (h.splats > ReadLimits().maxSplats)
        return fail(Code::CorruptData, "SPZ: {} splats, the limit is {}", h.splats, ReadLimits().maxSplats);
    uint64_t total = 0;
    for (const uint64_t bytes : attributeBytes(h)) total += bytes;
    if (total > kFreeExpansionBytes + kMaxSpzExpansion * fileBytes)
        return fail(Code::CorruptData,
                    "SPZ: {} splats of SH degree {} from {} bytes: no real file packs that tightly, the header is damaged", h.splats,
                    uint32_t(h.shDegree), fileBytes);
    return {};
}

/** Inflates one gzip stream piece by piece into memory of the caller. */
class Gunzip {
public:
    static Result<std::unique_ptr<Gunzip>> open(std::span<const uint8_t> bytes) {
        auto made = std::make_unique<Gunzip>();
        made->stream_.next_in = const_cast<Bytef*>(bytes.data());
        made->left_ = bytes.size();
        if (inflateInit2(&made->stream_, 16 + MAX_WBITS) != Z_OK) return outOfMemory("inflate an SPZ file");
        made->open_ = true;
        return made;
    }
    Gunzip() = default;
    Gunzip(const Gunzip&) = delete;
    Gunzip& operator=(const Gunzip&) = delete;
    ~Gunzip() {
        if (open_) inflateEnd(&stream_);
    }

    /** Fills `out`; returns the number of bytes, fewer at the end of the stream. */
    Result<size_t> read(std::span<uint8_t> out) {
        constexpr size_t kMost = 1u << 30;  // zlib counts in 32 bits
        size_t done = 0;
        while (done < out.size() && !ended_) {
            const size_t room = std::min(out.size() - done, kMost), given = std::min(left_, kMost);
            stream_.next_out = out.data() + done, stream_.avail_out = uInt(room), stream_.avail_in = uInt(given);
            const int result = inflate(&stream_, Z_NO_FLUSH);
            done += room - stream_.avail_out, left_ -= given - stream_.avail_in;
            if (result == Z_MEM_ERROR) return outOfMemory("inflate an SPZ file");
            if (result != Z_OK && result != Z_STREAM_END) return fail(Code::CorruptData, "SPZ: the gzip stream is damaged or truncated");
            ended_ = result == Z_STREAM_END;
        }
        return done;
    }

private:
    z_stream stream_{};
    size_t left_ = 0;
    bool open_ = false, ended_ = false;
};

Result<Packed> openGzip(std::span<const uint8_t> bytes) {
    DPL_TRY(auto stream, Gunzip::open(bytes));
    Packed p;
    std::array<uint8_t, sizeof(Header)> raw{};
    DPL_TRY(const size_t got, stream->read(raw));
    if (got != raw.size()) return fail(Code::CorruptData, "SPZ: the file ends in its header");
    std::memcpy(&p.header, raw.data(), sizeof(Header));
    DPL_RETURN_IF_ERROR(checkHeader(p.header, bytes.size()));
    if (p.header.version > 3)
        return fail(Code::CorruptData, "SPZ: version {} inside a gzip stream; only versions 2 and 3 are gzip streams", p.header.version);
    const auto sizes = attributeBytes(p.header);
    for (size_t a = 0; a < kAttributes; ++a) {
        p.attributes[a].resize(sizes[a]);
        DPL_RETURN_IF_ERROR(taskAt(double(a) / kAttributes));
        DPL_TRY(const size_t filled, stream->read(p.attributes[a]));
        if (filled != sizes[a]) return fail(Code::CorruptData, "SPZ: {} splats announced, the data ends early: truncated", p.header.splats);
    }
    // Reads to the end of the stream, where zlib checks the checksum.
    std::vector<uint8_t> rest(4096);
    while (true) {
        DPL_TRY(const size_t more, stream->read(rest));
        if (more == 0) return p;
        p.extensions.insert(p.extensions.end(), rest.begin(), rest.begin() + ptrdiff_t(more));
        if (p.extensions.size() > (p.header.flags & kExtensionFlag ? kMaxExtensionBytes : 0))
            return fail(Code::CorruptData, "SPZ: there is more data than {} splats need", p.header.splats);
    }
}

/** Layout: 32 bytes of header (the last 12 reserved); extensions; a table with two u64 (packed and unpacked size) per stream; the streams.
 */
Result<Packed> openZstd(std::span<const uint8_t> bytes) {
    Reader in(bytes);
    Packed p;
    DPL_TRY(p.header, in.value<Header>());
    DPL_RETURN_IF_ERROR(checkHeader(p.header, bytes.size()));
    if (p.header.version < 4) return fail(Code::CorruptData, "SPZ: version {} outside a gzip stream", p.header.version);
    DPL_TRY(const uint32_t tableAt, in.u32());
    DPL_RETURN_IF_ERROR(in.skip(12));
    static_assert(kHeader4Bytes == sizeof(Header) + 4 + 12);
    if (tableAt < in.position()) return fail(Code::CorruptData, "SPZ: the table of streams at byte {} lies inside the header", tableAt);
    DPL_TRY(const auto extensions, in.take(tableAt - in.position()));
    p.extensions.assign(extensions.begin(), extensions.begin() + ptrdiff_t(std::min<uint64_t>(extensions.size(), kMaxExtensionBytes)));
    const auto sizes = attributeBytes(p.header);
    const size_t stored =
        size_t(std::count_if(sizes.begin(), sizes.end(), [](uint64_t bytes) { return bytes > 0; }));  // empty streams are not stored
    if (p.header.streams != stored)
        return fail(Code::CorruptData, "SPZ: {} streams, {} splats of SH degree {} have {}", uint32_t(p.header.streams), p.header.splats,
                    uint32_t(p.header.shDegree), stored);
    std::array<uint64_t, kAttributes> packedBytes{};
    for (size_t a = 0; a < kAttributes; ++a) {
        if (sizes[a] == 0) continue;
        DPL_TRY(packedBytes[a], in.value<uint64_t>());
        DPL_TRY(const uint64_t unpacked, in.value<uint64_t>());
        if (unpacked != sizes[a])
            return fail(Code::CorruptData, "SPZ: stream {} unpacks to {} bytes, {} are needed", a, unpacked, sizes[a]);
    }
    for (size_t a = 0; a < kAttributes; ++a) {
        if (sizes[a] == 0) continue;
        DPL_RETURN_IF_ERROR(taskAt(double(a) / kAttributes));
        DPL_TRY(const auto packed, in.take(packedBytes[a]));
        p.attributes[a].resize(sizes[a]);
        const size_t got = ZSTD_decompress(p.attributes[a].data(), sizes[a], packed.data(), packed.size());
        if (ZSTD_getErrorCode(got) == ZSTD_error_memory_allocation) return outOfMemory("decompress an SPZ file");
        if (ZSTD_isError(got)) return fail(Code::CorruptData, "SPZ: stream {} is damaged ({})", a, ZSTD_getErrorName(got));
        if (got != sizes[a]) return fail(Code::CorruptData, "SPZ: stream {} gave {} of {} bytes", a, got, sizes[a]);
    }
    return p;
}

Result<Packed> openSpz(std::span<const uint8_t> bytes) {
    const bool gzip = bytes.size() >= 2 && bytes[0] == 0x1f && bytes[1] == 0x8b;
    return gzip ? openGzip(bytes) : openZstd(bytes);
}

float fixed24(const uint8_t* from, float step) {
    const uint32_t bits = uint32_t(from[0]) | uint32_t(from[1]) << 8 | uint32_t(from[2]) << 16;
    return float(int32_t(bits << 8) >> 8) * step;
}

/** Version 2: x, y, z in 8 bits each, w ≥ 0. */
Quatf rotationFromThree(const uint8_t* r) {
    const Vec3f v = Vec3f(r[0], r[1], r[2]) / 127.5f - 1.0f;
    return glm::normalize(Quatf(std::sqrt(std::max(0.0f, 1 - glm::dot(v, v))), v.x, v.y, v.z));
}

/** Versions 3 and 4: the top two bits tell which of x, y, z, w is the largest; it is left out. The others take 10 bits each, the last one
 *  in the lowest bits: a sign above 9 bits of magnitude (511 = 1/√2). */
Quatf rotationSmallestThree(const uint8_t* r) {
    uint32_t word;
    std::memcpy(&word, r, 4);
    const uint32_t largest = word >> 30;
    std::array<float, 4> q{};
    float squares = 0;
    for (uint32_t k = 4; k-- > 0;) {
        if (k == largest) continue;
        const float magnitude = float(word & 511) * float(std::sqrt(0.5) / 511);
        q[k] = word & 512 ? -magnitude : magnitude;
        squares += magnitude * magnitude;
        word >>= 10;
    }
    q[largest] = std::sqrt(std::max(0.0f, 1 - squares));
    return glm::normalize(Quatf(q[3], q[0], q[1], q[2]));
}

Result<StaticSplatData> unpack(const Packed& p) {
    const Header& h = p.header;
    const auto& [place, alpha, colour, scale, rotation, rest] = p.attributes;
    const size_t n = h.splats;
    StaticSplatData s;
    s.shDegree = std::min<uint32_t>(h.shDegree, kMaxShDegree);
    s.compensated = (h.flags & kAntialiasedFlag) != 0;
    const size_t coefficients = shCoefficientCount(s.shDegree), fileRest = (shCoefficientCount(h.shDegree) - 1) * 3;
    s.position.resize(n), s.rotation.resize(n), s.scaleM.resize(n), s.opacity.resize(n), s.sh.resize(n * coefficients * 3);
    const float step = 1.0f / float(1u << h.fractionalBits);
    for (size_t i = 0; i < n; ++i) {
        if (i % kLook == 0) {
            DPL_RETURN_IF_ERROR(taskAt(double(i) / double(n)));
        }
        float* sh = s.sh.data() + i * coefficients * 3;
        for (int k = 0; k < 3; ++k) {
            s.position[i][k] = fixed24(&place[i * 9 + size_t(k) * 3], step);
            s.scaleM[i][k] = std::exp(float(scale[i * 3 + size_t(k)]) / 16 - 10);
            sh[k] = (float(colour[i * 3 + size_t(k)]) / 255 - 0.5f) / 0.15f;
        }
        s.rotation[i] = h.version == 2 ? rotationFromThree(&rotation[i * 3]) : rotationSmallestThree(&rotation[i * 4]);
        s.opacity[i] = float(alpha[i]) / 255;
        // Coefficient-major with the colour channel fastest, as in StaticSplatData.
        for (size_t k = 3; k < coefficients * 3; ++k) sh[k] = (float(rest[i * fileRest + k - 3]) - 128) / 128;
    }
    return s;
}

}  // namespace

Result<StaticSplatData> readSpz(std::span<const uint8_t> bytes, SpzInfo* info) try {
    Packed packed;
    {
        const TaskPart part(0, 0.6);
        DPL_TRY(packed, openSpz(bytes));
    }
    if (info) {
        *info = {packed.header.version, packed.header.splats, packed.header.shDegree, {}};
        info->remarks.shDegree = packed.header.shDegree;
        noteShDegree(info->remarks);
        info->remarks.axes = axesOf(packed.extensions, info->remarks.notes);
    }
    const TaskPart part(0.6, 1);
    return unpack(packed);
} catch (const std::bad_alloc&) {
    return outOfMemory("read an SPZ file");
}

}  // namespace dpl
