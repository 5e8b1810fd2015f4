// SPDX-License-Identifier: Apache-2.0
// JPEG and PNG bytes to pixels and back. Rows are tight, the top row first; 8 bits a channel; colour is RGB, alpha is straight.
//
// The functions may be called from any thread. They check no limit on the size of a picture: readCompleteImage (reconstruction/capture)
// does that for files from outside before a byte is decoded.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

struct Picture {
    uint32_t widthPx = 0, heightPx = 0;
    uint32_t channels = 0;        // 1 grey, 3 RGB, 4 RGBA
    std::vector<uint8_t> pixels;  // widthPx · heightPx · channels
};

enum class PictureChannels : uint8_t {
    AsStored,  // 1, 3 or 4; a palette becomes RGB, grey with alpha becomes RGBA
    Rgb,       // always 3; grey is repeated, alpha is dropped
};

/** Decodes a JPEG or PNG. Sixteen bits become eight by rounding. EXIF orientation is ignored: intrinsics speak of the pixels as stored.
 *  CorruptData: the bytes are damaged. Unsupported: neither format, or a JPEG in CMYK. Errors do not name the file: the caller knows it. */
Result<Picture> decodePicture(std::span<const uint8_t> file, PictureChannels channels);

/** PNG bytes. channels: 1, 3 or 4. InvalidArgument: the number of pixels is not widthPx · heightPx · channels, or is zero. */
Result<std::vector<uint8_t>> encodePng(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels);

/** JPEG bytes, 4:2:0. channels: 1 or 3. quality: 1 to 100. */
Result<std::vector<uint8_t>> encodeJpeg(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels,
                                        int quality);

}  // namespace dpl
