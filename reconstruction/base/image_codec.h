// SPDX-License-Identifier: Apache-2.0
// Decodes and encodes JPEG and PNG. Pixels have 8 bits per channel, RGB and straight alpha; rows are tightly packed, top row first.
//
// Call from any thread. Picture sizes are not limited here: for untrusted files, readCompleteImage (reconstruction/input/capture) checks
// the size before decoding.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct Picture {
    uint32_t widthPx = 0, heightPx = 0;
    uint32_t channels = 0;        // 1 grey, 3 RGB, 4 RGBA
    std::vector<uint8_t> pixels;  // widthPx · heightPx · channels
};

enum class PictureChannels : uint8_t {
    AsStored,  // numbers as they are, for masks and labels. 1, 3 or 4; a palette becomes RGB, grey with alpha becomes RGBA
    Rgb,       // sRGB, always 3; grey is repeated, alpha is dropped
    Rgba,      // sRGB and alpha, always 4; 255 where the file has no alpha
};

/** What a file states of its colours, apart from sRGB. */
struct PictureColours {
    std::string converted;  // the space from which Rgb and Rgba are converted: "Display P3", "CMYK"; empty: none
    std::string unread;     // a profile of tables, or a damaged one, which is not read: the numbers are taken for sRGB; empty: none
};

/** Decodes a JPEG or PNG. 16-bit channels are rounded to 8 bits. Rgb and Rgba are sRGB: an embedded ICC profile of curves and a matrix is
 *  applied; CMYK becomes RGB without a profile. EXIF orientation is ignored because intrinsics refer to the pixels as stored. `colours` may
 *  be null. CorruptData: the bytes are damaged, the compressed pixels of a JPEG included. Unsupported: neither format. Errors do not name
 *  the file. */
Result<Picture> decodePicture(std::span<const uint8_t> file, PictureChannels channels, PictureColours* colours = nullptr);

/** Whether decodePicture can decode the picture. A JPEG takes a third of its time. */
Status checkPicture(std::span<const uint8_t> file);

/** Data of the first chunk of a type in a PNG ("eXIf"); empty: there is none, it is no PNG, or it is cut short. */
std::span<const uint8_t> pngChunk(std::span<const uint8_t> file, const char (&type)[5]);

/** Payload of the first segment of a JPEG before its pixels that has this marker and begins with `start`, without `start`; else empty.
 * `from`: where to search on, which is set behind the segment; begin with 0. */
std::span<const uint8_t> jpegSegment(std::span<const uint8_t> file, uint8_t marker, std::string_view start, size_t& from);

/** PNG bytes. channels: 1, 3 or 4. InvalidArgument: other channels, or pixels.size() is zero or not widthPx · heightPx · channels. */
Result<std::vector<uint8_t>> encodePng(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels);

/** JPEG bytes, chroma 4:2:0. channels: 1 or 3. quality: 1 to 100. InvalidArgument as for encodePng. */
Result<std::vector<uint8_t>> encodeJpeg(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels,
                                        int quality);

}  // namespace dpl
