// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/image_file.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string_view>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/base/image_size.h"
#include "reconstruction/base/program.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using Bytes = std::span<const uint8_t>;

constexpr uintmax_t kMaxFileBytes = 256u << 20;
constexpr size_t kProbeBytes = 512u << 10;  // EXIF thumbnails and colour profiles may precede the size
constexpr uint8_t kPngSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

uint32_t big16(Bytes b, size_t at) {
    return uint32_t(b[at]) << 8 | b[at + 1];
}
uint32_t big32(Bytes b, size_t at) {
    return big16(b, at) << 16 | big16(b, at + 2);
}

bool has(Bytes b, size_t at, std::string_view text) {
    return b.size() >= at + text.size() && std::memcmp(b.data() + at, text.data(), text.size()) == 0;
}

/** The format of a picture that is neither JPEG nor PNG; empty: unknown. */
std::string otherFormat(Bytes b) {
    if (has(b, 4, "ftyp")) {
        for (const char* brand : {"heic", "heix", "heim", "heis", "hevc", "hevx", "mif1", "msf1"})
            if (has(b, 8, brand)) return "HEIC";
        if (has(b, 8, "avif") || has(b, 8, "avis")) return "AVIF";
    }
    if (has(b, 0, "RIFF") && has(b, 8, "WEBP")) return "WebP";
    if (has(b, 0, std::string_view("II*\0", 4)) || has(b, 0, std::string_view("MM\0*", 4))) return "TIFF";
    return has(b, 0, "GIF8") ? "GIF" : has(b, 0, "BM") ? "BMP" : "";
}

Error neitherJpegNorPng(Bytes b, const fs::path& path) {
    const std::string format = otherFormat(b), name = path.string();
    if (format.empty()) return fail(Code::Unsupported, "{}: neither JPEG nor PNG; convert the image", name);
    if (format == "HEIC")
        return fail(Code::Unsupported, "{}: HEIC is not read; convert it (apt-get install libheif-examples): heif-convert -q 95 {} {}",
                    name, shellWord(path), shellWord(name + ".jpg"));
    return fail(Code::Unsupported, "{}: {} is not read; convert it: ffmpeg -i {} {}", name, format, shellWord(path),
                shellWord(name + ".png"));
}

struct Walk {
    ImageHeader header;
    bool complete = false;  // the end marker was reached
};

/** Walks JPEG markers; after a start of scan it skips entropy-coded bytes up to the next marker that is neither stuffing nor a restart. */
Walk walkJpeg(Bytes b, bool wholeFile) {
    Walk walk;
    size_t at = 2;
    bool inScan = false;
    while (at + 1 < b.size()) {
        if (b[at] != 0xff) {
            if (!inScan) return walk;
            const void* next = std::memchr(b.data() + at, 0xff, b.size() - at);
            if (!next) return walk;
            at = size_t(static_cast<const uint8_t*>(next) - b.data());
            continue;
        }
        const uint8_t marker = b[at + 1];
        if (marker == 0xff) {
            ++at;
            continue;
        }  // fill byte
        if (marker == 0x00 || (marker >= 0xd0 && marker <= 0xd7) || marker == 0x01) {
            at += 2;
            continue;
        }  // stuffing, restart
        if (marker == 0xd9) {
            walk.complete = true;
            return walk;
        }
        if (at + 4 > b.size()) return walk;
        const size_t length = big16(b, at + 2);
        if (length < 2 || at + 2 + length > b.size()) return walk;
        const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
        if (frame && length >= 7) {
            walk.header = {big16(b, at + 7), big16(b, at + 5)};
            if (!wholeFile) return walk;
        }
        inScan = marker == 0xda;
        at += 2 + length;
    }
    return walk;
}

Walk walkPng(Bytes b, bool wholeFile) {
    Walk walk;
    if (b.size() < 33 || std::memcmp(b.data() + 12, "IHDR", 4) != 0) return walk;
    walk.header = {big32(b, 16), big32(b, 20)};
    if (!wholeFile) return walk;
    for (size_t at = 8; at + 12 <= b.size();) {
        const size_t length = big32(b, at);
        if (length > b.size() - at - 12) return walk;
        if (std::memcmp(b.data() + at + 4, "IEND", 4) == 0) {
            walk.complete = true;
            return walk;
        }
        at += 12 + length;
    }
    return walk;
}

Result<Walk> walkImage(Bytes b, bool wholeFile, const fs::path& path) {
    Walk walk;
    if (b.size() >= 4 && b[0] == 0xff && b[1] == 0xd8)
        walk = walkJpeg(b, wholeFile);
    else if (b.size() >= 8 && std::memcmp(b.data(), kPngSignature, 8) == 0)
        walk = walkPng(b, wholeFile);
    else if (b.empty())
        return fail(Code::CorruptData, "{}: the file is empty; copy it again", path.string());
    else
        return neitherJpegNorPng(b, path);
    if (walk.header.widthPx == 0 || walk.header.heightPx == 0)
        return fail(Code::CorruptData, "{}: damaged before its size could be read; copy the image again", path.string());
    DPL_RETURN_IF_ERROR(checkImageSize(walk.header.widthPx, walk.header.heightPx, path.string()));
    return walk;
}

Result<std::vector<uint8_t>> readBytes(const fs::path& path, uintmax_t most) {
    std::error_code error;
    if (!fs::is_regular_file(path, error))
        return fail(Code::NotFound, "{}: not found; restore the file or remove the frame", path.string());
    const uintmax_t bytes = fs::file_size(path, error);
    if (error) return fail(Code::Io, "{}: {}; check its permissions", path.string(), error.message());
    if (bytes > kMaxFileBytes)
        return fail(Code::Unsupported, "{}: {} bytes, at most 256 MiB are read; save it smaller", path.string(), bytes);
    std::vector<uint8_t> data(size_t(std::min(bytes, most)));
    std::ifstream in(path, std::ios::binary);
    if (!data.empty() && !in.read(reinterpret_cast<char*>(data.data()), std::streamsize(data.size())))
        return fail(Code::Io, "{}: cannot be read; check its permissions", path.string());
    return data;
}

}  // namespace

Result<ImageHeader> probeImage(const fs::path& path) {
    DPL_TRY(auto bytes, readBytes(path, kProbeBytes));
    DPL_TRY(const Walk walk, walkImage(bytes, false, path));
    return walk.header;
}

namespace {

Result<ImageHeader> completeHeader(Bytes bytes, const fs::path& path) {
    DPL_TRY(const Walk walk, walkImage(bytes, true, path));
    if (walk.complete) return walk.header;
    return fail(Code::CorruptData, "{}: the file is truncated ({} bytes without an end); copy the image again", path.string(),
                bytes.size());
}

}  // namespace

Status checkCompleteImage(Bytes bytes, const fs::path& path) {
    DPL_RETURN_IF_ERROR(completeHeader(bytes, path));
    return {};
}

Result<std::vector<uint8_t>> readCompleteImage(const fs::path& path) {
    DPL_TRY(auto bytes, readBytes(path, kMaxFileBytes));
    DPL_RETURN_IF_ERROR(checkCompleteImage(bytes, path));
    return bytes;
}

Result<ImageHeader> probeCompleteImage(const fs::path& path) {
    DPL_TRY(const auto bytes, readBytes(path, kMaxFileBytes));
    return completeHeader(bytes, path);
}

Status checkPicturePixels(const fs::path& path) {
    DPL_TRY(const auto bytes, readBytes(path, kMaxFileBytes));
    const Status sound = checkPicture(bytes);
    if (!sound) return fail(sound.error().code, "{}: {}; copy or export the picture again", path.string(), sound.error().message);
    return {};
}

}  // namespace dpl
