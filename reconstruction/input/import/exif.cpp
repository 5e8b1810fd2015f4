// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/exif.h"

#include <cmath>
#include <cstring>
#include <optional>

namespace dpl {
namespace {

using Bytes = std::span<const uint8_t>;

constexpr uint16_t kOrientation = 274, kExifDirectory = 34665, kFocalLength35Mm = 41989;
constexpr uint16_t kShort = 3, kLong = 4;
constexpr int kMaxEntries = 1024;

/** The payload of the first APP1 segment that begins with "Exif\0\0", or nothing. */
Bytes exifSegment(Bytes jpeg) {
    if (jpeg.size() < 4 || jpeg[0] != 0xff || jpeg[1] != 0xd8) return {};
    for (size_t at = 2; at + 4 <= jpeg.size() && jpeg[at] == 0xff;) {
        const uint8_t marker = jpeg[at + 1];
        if (marker == 0xff) {  // fill byte
            ++at;
            continue;
        }
        const size_t length = size_t(jpeg[at + 2]) << 8 | jpeg[at + 3];
        if (marker == 0xda || length < 2 || at + 2 + length > jpeg.size()) return {};
        const Bytes payload = jpeg.subspan(at + 4, length - 2);
        if (marker == 0xe1 && payload.size() >= 6 && std::memcmp(payload.data(), "Exif\0\0", 6) == 0) return payload.subspan(6);
        at += 2 + length;
    }
    return {};
}

/** A TIFF structure: numbers in the byte order of its header, directories of 12-byte entries. */
class Tiff {
public:
    explicit Tiff(Bytes bytes) : bytes_(bytes) {
        if (bytes.size() < 8) return;
        little_ = bytes[0] == 'I' && bytes[1] == 'I';
        good_ = (little_ || (bytes[0] == 'M' && bytes[1] == 'M')) && u16(2) == 42;
    }
    uint32_t firstDirectory() const { return good_ ? u32(4) : 0; }

    /** The value of `tag` in the directory at `offset`, if it is one whole number. */
    std::optional<uint32_t> number(uint32_t offset, uint16_t tag) const {
        if (offset == 0 || offset + 2ull > bytes_.size()) return std::nullopt;
        const int count = std::min<int>(u16(offset), kMaxEntries);
        for (int i = 0; i < count; ++i) {
            const uint64_t entry = offset + 2ull + 12ull * uint64_t(i);
            if (entry + 12 > bytes_.size()) return std::nullopt;
            if (u16(entry) != tag || u32(entry + 4) != 1) continue;
            if (u16(entry + 2) == kShort) return u16(entry + 8);
            if (u16(entry + 2) == kLong) return u32(entry + 8);
        }
        return std::nullopt;
    }

private:
    uint32_t u16(uint64_t at) const {
        const uint32_t a = bytes_[at], b = bytes_[at + 1];
        return little_ ? a | b << 8 : a << 8 | b;
    }
    uint32_t u32(uint64_t at) const {
        const uint32_t a = u16(at), b = u16(at + 2);
        return little_ ? a | b << 16 : a << 16 | b;
    }
    Bytes bytes_;
    bool little_ = false, good_ = false;
};

}  // namespace

ExifFields readExif(Bytes jpeg) {
    ExifFields fields;
    const Tiff tiff(exifSegment(jpeg));
    const uint32_t first = tiff.firstDirectory();
    if (const auto orientation = tiff.number(first, kOrientation); orientation && *orientation >= 1 && *orientation <= 8)
        fields.orientation = int(*orientation);
    if (const auto exif = tiff.number(first, kExifDirectory))
        if (const auto focal = tiff.number(*exif, kFocalLength35Mm); focal && *focal >= 5 && *focal <= 1000)
            fields.focalLength35Mm = double(*focal);
    return fields;
}

double focalFrom35Mm(double focalLength35Mm, uint32_t widthPx, uint32_t heightPx) {
    return focalLength35Mm * std::hypot(double(widthPx), double(heightPx)) / std::hypot(36.0, 24.0);
}

}  // namespace dpl
