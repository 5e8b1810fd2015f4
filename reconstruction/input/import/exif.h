// SPDX-License-Identifier: Apache-2.0
// Orientation and focal length from the EXIF data of a JPEG or PNG. Follows Exif 2.32 (CIPA DC-008), TIFF 6.0 and the PNG chunk eXIf.
#pragma once

#include <cstdint>
#include <span>

namespace dpl {

struct ExifFields {
    int orientation = 1;         // 1 … 8, how the stored rows and columns lie in the upright picture (TIFF tag 274)
    double focalLength35Mm = 0;  // FocalLengthIn35mmFilm (tag 41989); 0: not stated
};

/** Reads the first EXIF segment of a JPEG, or the eXIf chunk of a PNG. Missing or damaged data give the default values: EXIF never makes a
 *  picture unreadable. Looks at no more than 1024 directory entries and allocates nothing. */
ExifFields readExif(std::span<const uint8_t> picture);

/** Focal length in pixels. The 35 mm equivalent compares diagonals: that of 35 mm film is 43.27 mm. */
double focalFrom35Mm(double focalLength35Mm, uint32_t widthPx, uint32_t heightPx);

}  // namespace dpl
