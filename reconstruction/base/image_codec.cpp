// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/image_codec.h"

#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <map>
#include <memory>

#include "reconstruction/base/colour_profile.h"
#include "sdk/core/numbers.h"

namespace dpl {
namespace {

constexpr int kPngCompression = 6;
constexpr png_alloc_size_t kMaxPngChunkBytes = 8u << 20;  // limit for chunks of profiles and texts, not for pixels

bool beginsWith(std::span<const uint8_t> file, std::initializer_list<uint8_t> magic) {
    return file.size() >= magic.size() && std::equal(magic.begin(), magic.end(), file.begin());
}

Status checkPixels(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels) {
    if (!pixels.empty() && pixels.size() == size_t(widthPx) * heightPx * channels) return {};
    return fail(Code::InvalidArgument, "{} bytes are not a {} x {} picture of {} channels", pixels.size(), widthPx, heightPx, channels);
}

// ── JPEG ──

struct TurboHandle {
    tjhandle handle;
    ~TurboHandle() {
        if (handle) tjDestroy(handle);
    }
};

uint32_t big32(std::span<const uint8_t> b, size_t at) {
    return uint32_t(b[at]) << 24 | uint32_t(b[at + 1]) << 16 | uint32_t(b[at + 2]) << 8 | b[at + 3];
}

/** Whether `count` equal bytes stand before some marker of this kind: padding that a phone wrote, not pixels that were not decoded. */
bool isPadding(std::span<const uint8_t> file, size_t count, uint8_t marker) {
    for (size_t at = count; at + 1 < file.size(); ++at) {
        if (file[at] != 0xff || file[at + 1] != marker) continue;
        const auto before = file.subspan(at - count, count);
        if (std::all_of(before.begin(), before.end(), [&](uint8_t byte) { return byte == before.front(); })) return true;
    }
    return false;
}

/** Whether the picture is complete in spite of what libjpeg-turbo warns of, which is the first of its warnings. */
bool isHarmless(std::string_view warning, std::span<const uint8_t> file) {
    constexpr std::string_view kCorrupt = "Corrupt JPEG data: ", kExtra = " extraneous bytes before marker 0x";
    if (!warning.starts_with(kCorrupt)) return !warning.starts_with("Premature end") && !warning.starts_with("Inconsistent progression");
    warning.remove_prefix(kCorrupt.size());
    if (warning == "bad ICC marker") return true;
    const size_t extra = warning.find(kExtra);
    if (extra == std::string_view::npos) return false;
    const std::string_view hex = warning.substr(extra + kExtra.size(), 2);
    constexpr std::string_view kDigits = "0123456789abcdef";
    const size_t high = kDigits.find(hex[0]), low = hex.size() == 2 ? kDigits.find(hex[1]) : std::string_view::npos;
    size_t count = 0;
    return high < 16 && low < 16 && readNumber(warning.substr(0, extra), count) && isPadding(file, count, uint8_t(16 * high + low));
}

/** The ICC profile of a JPEG, which may be cut into 255 numbered segments; empty if it has none. Missing segments leave it too short. */
std::vector<uint8_t> profileOfJpeg(std::span<const uint8_t> file) {
    std::map<uint8_t, std::span<const uint8_t>> parts;
    for (size_t from = 0;;) {
        const auto part = jpegSegment(file, 0xe2, std::string_view("ICC_PROFILE\0", 12), from);
        if (part.size() < 2) break;
        parts.emplace(part[0], part.subspan(2));
    }
    std::vector<uint8_t> profile;
    for (const auto& [number, part] : parts) profile.insert(profile.end(), part.begin(), part.end());
    return profile;
}

/** RGB of CMYK without a profile. Adobe's programs store the inverse of the inks and say so by a segment of their own. */
std::vector<uint8_t> rgbOfCmyk(std::span<const uint8_t> cmyk, bool inverted) {
    std::vector<uint8_t> rgb(cmyk.size() / 4 * 3);
    const auto paper = [&](uint8_t ink) { return inverted ? uint32_t(ink) : 255u - ink; };
    for (size_t i = 0; i < cmyk.size() / 4; ++i)
        for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = uint8_t((paper(cmyk[4 * i + c]) * paper(cmyk[4 * i + 3]) + 127) / 255);
    return rgb;
}

/** shrink: 1 or 8. A picture that is shrunk while it is decoded takes a third of the time; its compressed pixels are all read. */
Result<Picture> decodeJpeg(std::span<const uint8_t> file, bool asStored, PictureColours& colours, int shrink = 1) {
    const TurboHandle turbo{tjInitDecompress()};
    if (!turbo.handle) return fail(Code::OutOfMemory, "no memory to decode a JPEG");
    int widthPx = 0, heightPx = 0, subsampling = 0, colourSpace = 0;
    const auto bytes = static_cast<unsigned long>(file.size());
    if (tjDecompressHeader3(turbo.handle, file.data(), bytes, &widthPx, &heightPx, &subsampling, &colourSpace) != 0)
        return fail(Code::CorruptData, "damaged JPEG ({})", tjGetErrorStr2(turbo.handle));
    widthPx = (widthPx + shrink - 1) / shrink, heightPx = (heightPx + shrink - 1) / shrink;
    const bool cmyk = colourSpace == TJCS_CMYK || colourSpace == TJCS_YCCK;
    const bool grey = colourSpace == TJCS_GRAY && asStored;
    const int format = cmyk ? TJPF_CMYK : grey ? TJPF_GRAY : TJPF_RGB;
    Picture picture{uint32_t(widthPx), uint32_t(heightPx), cmyk ? 4u : grey ? 1u : 3u, {}};
    picture.pixels.resize(size_t(picture.widthPx) * picture.heightPx * picture.channels);
    const int decoded =
        tjDecompress2(turbo.handle, file.data(), bytes, picture.pixels.data(), widthPx, 0, heightPx, format, TJFLAG_ACCURATEDCT);
    if (decoded != 0 && (tjGetErrorCode(turbo.handle) != TJERR_WARNING || !isHarmless(tjGetErrorStr2(turbo.handle), file)))
        return fail(Code::CorruptData, "damaged JPEG ({})", tjGetErrorStr2(turbo.handle));
    if (cmyk) {
        size_t from = 0;
        picture.pixels = rgbOfCmyk(picture.pixels, !jpegSegment(file, 0xee, "Adobe", from).empty());
        picture.channels = 3;
        colours.converted = "CMYK";
    }
    return picture;
}

// ── PNG ──
// libpng reports errors by longjmp, which skips destructors. Functions with setjmp therefore own no objects: the caller owns them.

struct PngSource {
    std::span<const uint8_t> left;
    char error[128] = "";
};

void pngRead(png_structp png, png_bytep to, size_t bytes) {
    auto& source = *static_cast<PngSource*>(png_get_io_ptr(png));
    if (bytes > source.left.size()) png_error(png, "it ends too early");
    std::memcpy(to, source.left.data(), bytes);
    source.left = source.left.subspan(bytes);
}
[[noreturn]] void pngFail(png_structp png, png_const_charp text) {
    auto* error = static_cast<char*>(png_get_error_ptr(png));
    std::strncpy(error, text, sizeof PngSource::error - 1);
    std::longjmp(png_jmpbuf(png), 1);
}
void pngIgnore(png_structp, png_const_charp) {}

/** The profile of a PNG, unpacked by libpng; valid as long as `info`. */
std::span<const uint8_t> profileOfPng(png_structp png, png_infop info) {
    if (setjmp(png_jmpbuf(png))) return {};
    png_charp name = nullptr;
    png_bytep profile = nullptr;
    png_uint_32 bytes = 0;
    int compression = 0;
    if (png_get_iCCP(png, info, &name, &compression, &profile, &bytes) != PNG_INFO_iCCP) return {};
    return {profile, bytes};
}

/** Reads the header and sets libpng up to give grey, RGB or RGBA with 8 or 16 bits. False on an error, whose text is in PngSource::error.
 */
bool readPngHeader(png_structp png, png_infop info, PictureChannels channels, Picture& picture, bool& wide) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_chunk_malloc_max(png, kMaxPngChunkBytes);
    png_read_info(png, info);
    const png_byte type = png_get_color_type(png, info);
    const bool transparent = (type & PNG_COLOR_MASK_ALPHA) != 0 || png_get_valid(png, info, PNG_INFO_tRNS) != 0;
    const bool rgbOnly = channels == PictureChannels::Rgb, rgba = channels == PictureChannels::Rgba;
    png_set_expand(png);  // palettes, fewer than 8 bits, transparent colours
    if (rgbOnly && transparent) png_set_strip_alpha(png);
    if (rgba && !transparent) png_set_add_alpha(png, 0xffff, PNG_FILLER_AFTER);
    if ((type & PNG_COLOR_MASK_COLOR) == 0 && (rgbOnly || rgba || transparent)) png_set_gray_to_rgb(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    wide = png_get_bit_depth(png, info) == 16;
    picture.widthPx = png_get_image_width(png, info), picture.heightPx = png_get_image_height(png, info);
    picture.channels = png_get_channels(png, info);
    return true;
}

bool readPngRows(png_structp png, png_bytepp rows) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_read_image(png, rows);
    png_read_end(png, nullptr);
    return true;
}

Result<Picture> decodePng(std::span<const uint8_t> file, PictureChannels channels, std::vector<uint8_t>& profile) {
    PngSource source{file};
    struct Reader {
        png_structp png;
        png_infop info;
        ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
    };
    Reader reader{png_create_read_struct(PNG_LIBPNG_VER_STRING, source.error, pngFail, pngIgnore), nullptr};
    if (reader.png) reader.info = png_create_info_struct(reader.png);
    if (!reader.info) return fail(Code::OutOfMemory, "no memory to decode a PNG");
    png_set_read_fn(reader.png, &source, pngRead);
    Picture picture;
    bool wide = false;
    if (!readPngHeader(reader.png, reader.info, channels, picture, wide)) return fail(Code::CorruptData, "damaged PNG ({})", source.error);
    const auto stated = profileOfPng(reader.png, reader.info);
    profile.assign(stated.begin(), stated.end());
    const size_t rowBytes = size_t(picture.widthPx) * picture.channels * (wide ? 2 : 1);
    std::vector<uint8_t> bytes(rowBytes * picture.heightPx);
    std::vector<png_bytep> rows(picture.heightPx);
    for (size_t y = 0; y < rows.size(); ++y) rows[y] = bytes.data() + y * rowBytes;
    if (!readPngRows(reader.png, rows.data())) return fail(Code::CorruptData, "damaged PNG ({})", source.error);
    if (wide) {  // 16 bits big-endian to 8 bits: 65535 = 257 · 255
        for (size_t i = 0; i < bytes.size() / 2; ++i) bytes[i] = uint8_t(((uint32_t(bytes[2 * i]) << 8 | bytes[2 * i + 1]) + 128) / 257);
        bytes.resize(bytes.size() / 2);
    }
    picture.pixels = std::move(bytes);
    return picture;
}

void pngAppend(png_structp png, png_bytep bytes, size_t count) {
    auto& out = *static_cast<std::vector<uint8_t>*>(png_get_io_ptr(png));
    out.insert(out.end(), bytes, bytes + count);
}
void pngFlush(png_structp) {}

bool writePng(png_structp png, png_infop info, std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels) {
    if (setjmp(png_jmpbuf(png))) return false;
    const int type = channels == 1 ? PNG_COLOR_TYPE_GRAY : channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA;
    png_set_IHDR(png, info, widthPx, heightPx, 8, type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, kPngCompression);
    png_write_info(png, info);
    for (size_t y = 0; y < heightPx; ++y) png_write_row(png, pixels.data() + y * widthPx * channels);
    png_write_end(png, nullptr);
    return true;
}

/** Converts colours to sRGB from what the file states of them. In a PNG a cICP chunk wins over a profile; of those, sRGB and Display P3 are
 *  read. */
void toSrgb(Picture& picture, std::span<const uint8_t> file, std::span<const uint8_t> profile, PictureColours& colours) {
    constexpr uint8_t kSrgbPrimaries = 1, kP3Primaries = 12, kSrgbTransfer = 13;  // ITU-T H.273
    Result<ColourSpace> space = ColourSpace{};
    if (const auto stated = pngChunk(file, "cICP"); stated.size() >= 2) {
        const bool srgbCurve = stated[1] == kSrgbTransfer;
        if (srgbCurve && stated[0] == kSrgbPrimaries) return;
        space = srgbCurve && stated[0] == kP3Primaries ? displayP3() : ColourSpace{"the colours of its cICP chunk", std::nullopt, false};
    } else if (!profile.empty()) {
        space = readColourProfile(profile);
    }
    if (!space || !space->known)
        colours.unread = space ? space->name : "a damaged colour profile";
    else if (space->toSrgb)
        space->toSrgb->apply(picture.pixels, picture.channels), colours.converted = space->name;
}

Picture withAlpha(const Picture& rgb) {
    Picture rgba{rgb.widthPx, rgb.heightPx, 4, std::vector<uint8_t>(rgb.pixels.size() / 3 * 4, 255)};
    for (size_t i = 0; i < rgb.pixels.size() / 3; ++i) std::copy_n(&rgb.pixels[3 * i], 3, &rgba.pixels[4 * i]);
    return rgba;
}

}  // namespace

std::span<const uint8_t> pngChunk(std::span<const uint8_t> file, const char (&type)[5]) {
    if (!beginsWith(file, {0x89, 'P', 'N', 'G'})) return {};
    for (size_t at = 8; at + 12 <= file.size();) {
        const size_t length = big32(file, at);
        if (length > file.size() - at - 12) return {};
        if (std::memcmp(&file[at + 4], type, 4) == 0) return file.subspan(at + 8, length);
        at += 12 + length;
    }
    return {};
}

std::span<const uint8_t> jpegSegment(std::span<const uint8_t> file, uint8_t marker, std::string_view start, size_t& from) {
    if (!beginsWith(file, {0xff, 0xd8})) return {};
    for (size_t at = std::max<size_t>(from, 2); at + 4 <= file.size() && file[at] == 0xff;) {
        if (file[at + 1] == 0xff) {  // fill byte
            ++at;
            continue;
        }
        const size_t length = size_t(file[at + 2]) << 8 | file[at + 3];
        if (file[at + 1] == 0xda || length < 2 || at + 2 + length > file.size()) return {};
        const auto payload = file.subspan(at + 4, length - 2);
        const bool found =
            file[at + 1] == marker && payload.size() >= start.size() && std::memcmp(payload.data(), start.data(), start.size()) == 0;
        at += 2 + length;
        if (!found) continue;
        from = at;
        return payload.subspan(start.size());
    }
    return {};
}

Result<Picture> decodePicture(std::span<const uint8_t> file, PictureChannels channels, PictureColours* colours) {
    const bool asStored = channels == PictureChannels::AsStored;
    PictureColours found;
    std::vector<uint8_t> profile;
    Picture picture;
    if (beginsWith(file, {0xff, 0xd8})) {
        DPL_TRY(picture, decodeJpeg(file, asStored, found));
        if (found.converted.empty()) profile = profileOfJpeg(file);
    } else if (beginsWith(file, {0x89, 'P', 'N', 'G'})) {
        DPL_TRY(picture, decodePng(file, channels, profile));
    } else {
        return fail(Code::Unsupported, "the image is neither JPEG nor PNG; convert it");
    }
    if (!asStored) toSrgb(picture, file, profile, found);
    if (channels == PictureChannels::Rgba && picture.channels == 3) picture = withAlpha(picture);
    if (colours) *colours = std::move(found);
    return picture;
}

Status checkPicture(std::span<const uint8_t> file) {
    if (!beginsWith(file, {0xff, 0xd8})) {
        DPL_TRY([[maybe_unused]] const Picture decoded, decodePicture(file, PictureChannels::AsStored));
        return {};
    }
    constexpr int kShrink = 8;
    PictureColours colours;
    DPL_TRY([[maybe_unused]] const Picture small, decodeJpeg(file, true, colours, kShrink));
    return {};
}

Result<std::vector<uint8_t>> encodePng(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels) {
    if (channels != 1 && channels != 3 && channels != 4)
        return fail(Code::InvalidArgument, "a PNG cannot have {} channels; use 1, 3 or 4", channels);
    DPL_RETURN_IF_ERROR(checkPixels(pixels, widthPx, heightPx, channels));
    char error[sizeof PngSource::error] = "";
    struct Writer {
        png_structp png;
        png_infop info;
        ~Writer() { png_destroy_write_struct(&png, &info); }
    };
    Writer writer{png_create_write_struct(PNG_LIBPNG_VER_STRING, error, pngFail, pngIgnore), nullptr};
    if (writer.png) writer.info = png_create_info_struct(writer.png);
    if (!writer.info) return fail(Code::OutOfMemory, "no memory to encode a PNG");
    std::vector<uint8_t> out;
    png_set_write_fn(writer.png, &out, pngAppend, pngFlush);
    if (!writePng(writer.png, writer.info, pixels, widthPx, heightPx, channels))
        return fail(Code::Internal, "a PNG of {} x {} px cannot be encoded ({})", widthPx, heightPx, error);
    return out;
}

Result<std::vector<uint8_t>> encodeJpeg(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels,
                                        int quality) {
    if (channels != 1 && channels != 3) return fail(Code::InvalidArgument, "a JPEG cannot have {} channels; use 1 or 3", channels);
    if (quality < 1 || quality > 100) return fail(Code::InvalidArgument, "JPEG quality {} is out of range; use 1 to 100", quality);
    DPL_RETURN_IF_ERROR(checkPixels(pixels, widthPx, heightPx, channels));
    const TurboHandle turbo{tjInitCompress()};
    if (!turbo.handle) return fail(Code::OutOfMemory, "no memory to encode a JPEG");
    unsigned char* bytes = nullptr;
    unsigned long count = 0;
    const int encoded = tjCompress2(turbo.handle, pixels.data(), int(widthPx), 0, int(heightPx), channels == 1 ? TJPF_GRAY : TJPF_RGB,
                                    &bytes, &count, channels == 1 ? TJSAMP_GRAY : TJSAMP_420, quality, TJFLAG_ACCURATEDCT);
    const std::unique_ptr<unsigned char, decltype(&tjFree)> owned(bytes, tjFree);
    if (encoded != 0)
        return fail(Code::Internal, "a JPEG of {} x {} px cannot be encoded ({})", widthPx, heightPx, tjGetErrorStr2(turbo.handle));
    return std::vector<uint8_t>(bytes, bytes + count);
}

}  // namespace dpl
