// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/exif.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "reconstruction/base/image_codec.h"

namespace dpl {
namespace {

using Bytes = std::span<const uint8_t>;

constexpr uint16_t kOrientation = 274, kExifDirectory = 34665, kFocalLength35Mm = 41989;
constexpr uint16_t kShort = 3, kLong = 4;
constexpr int kMaxEntries = 1024;

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

ExifFields readExif(Bytes picture) {
    ExifFields fields;
    constexpr std::string_view kStart("Exif\0\0", 6);
    size_t from = 0;
    Bytes data = jpegSegment(picture, 0xe1, kStart, from);
    if (data.empty()) data = pngChunk(picture, "eXIf");
    if (data.size() > kStart.size() && std::equal(kStart.begin(), kStart.end(), data.begin())) data = data.subspan(kStart.size());
    const Tiff tiff(data);
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
