// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/image_codec.h"

#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <memory>

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

Result<Picture> decodeJpeg(std::span<const uint8_t> file, PictureChannels channels) {
    const TurboHandle turbo{tjInitDecompress()};
    if (!turbo.handle) return fail(Code::OutOfMemory, "no memory to decode a JPEG");
    int widthPx = 0, heightPx = 0, subsampling = 0, colourSpace = 0;
    if (tjDecompressHeader3(turbo.handle, file.data(), static_cast<unsigned long>(file.size()), &widthPx, &heightPx, &subsampling,
                            &colourSpace) != 0)
        return fail(Code::CorruptData, "damaged JPEG ({})", tjGetErrorStr2(turbo.handle));
    if (colourSpace == TJCS_CMYK || colourSpace == TJCS_YCCK) return fail(Code::Unsupported, "the JPEG is in CMYK; save it as RGB");
    const bool grey = colourSpace == TJCS_GRAY && channels == PictureChannels::AsStored;
    Picture picture{uint32_t(widthPx), uint32_t(heightPx), grey ? 1u : 3u, {}};
    picture.pixels.resize(size_t(picture.widthPx) * picture.heightPx * picture.channels);
    const int decoded = tjDecompress2(turbo.handle, file.data(), static_cast<unsigned long>(file.size()), picture.pixels.data(), widthPx, 0,
                                      heightPx, grey ? TJPF_GRAY : TJPF_RGB, TJFLAG_ACCURATEDCT);
    // A warning means extra bytes between markers, which some phones write. The picture is complete.
    if (decoded != 0 && tjGetErrorCode(turbo.handle) != TJERR_WARNING)
        return fail(Code::CorruptData, "damaged JPEG ({})", tjGetErrorStr2(turbo.handle));
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

/** Reads the header and sets libpng up to give grey, RGB or RGBA with 8 or 16 bits. False on an error, whose text is in PngSource::error.
 */
bool readPngHeader(png_structp png, png_infop info, PictureChannels channels, Picture& picture, bool& wide) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_chunk_malloc_max(png, kMaxPngChunkBytes);
    png_read_info(png, info);
    const png_byte type = png_get_color_type(png, info);
    const bool transparent = (type & PNG_COLOR_MASK_ALPHA) != 0 || png_get_valid(png, info, PNG_INFO_tRNS) != 0;
    const bool rgbOnly = channels == PictureChannels::Rgb;
    png_set_expand(png);  // palettes, fewer than 8 bits, transparent colours
    if (rgbOnly && transparent) png_set_strip_alpha(png);
    if ((type & PNG_COLOR_MASK_COLOR) == 0 && (rgbOnly || transparent)) png_set_gray_to_rgb(png);
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

Result<Picture> decodePng(std::span<const uint8_t> file, PictureChannels channels) {
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

}  // namespace

Result<Picture> decodePicture(std::span<const uint8_t> file, PictureChannels channels) {
    if (beginsWith(file, {0xff, 0xd8})) return decodeJpeg(file, channels);
    if (beginsWith(file, {0x89, 'P', 'N', 'G'})) return decodePng(file, channels);
    return fail(Code::Unsupported, "the image is neither JPEG nor PNG; convert it");
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
