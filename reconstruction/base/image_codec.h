// SPDX-License-Identifier: Apache-2.0
// Decodes and encodes JPEG and PNG. Pixels have 8 bits per channel, RGB and straight alpha; rows are tightly packed, top row first.
//
// Call from any thread. Picture sizes are not limited here: for untrusted files, readCompleteImage (reconstruction/input/capture) checks
// the size before decoding.
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

/** Decodes a JPEG or PNG. 16-bit channels are rounded to 8 bits. EXIF orientation is ignored because intrinsics refer to the pixels as
 *  stored. CorruptData: the bytes are damaged. Unsupported: neither format, or a JPEG in CMYK. Errors do not name the file. */
Result<Picture> decodePicture(std::span<const uint8_t> file, PictureChannels channels);

/** PNG bytes. channels: 1, 3 or 4. InvalidArgument: other channels, or pixels.size() is zero or not widthPx · heightPx · channels. */
Result<std::vector<uint8_t>> encodePng(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels);

/** JPEG bytes, chroma 4:2:0. channels: 1 or 3. quality: 1 to 100. InvalidArgument as for encodePng. */
Result<std::vector<uint8_t>> encodeJpeg(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels,
                                        int quality);

}  // namespace dpl
