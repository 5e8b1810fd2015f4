// SPDX-License-Identifier: Apache-2.0
// The pixels of one frame. Every stage that needs pixels reads them through readFramePicture().
#pragma once

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** Decoded and undistorted; each plane has the size of the frame's camera. */
struct FramePicture {
    ImageRgb8 image;         // display-referred sRGB, background included
    ImageGrey8 mask;         // 0 … 255; isPerson() decides
    ImageGrey8 labels;       // label values; empty when the frame has no labels
    bool maskFound = false;  // as in ScanFrame
};

/** Whether a mask value counts as person. Thresholds soft mattes, so that training does not learn a translucent outline. */
constexpr bool isPerson(uint8_t mask) {
    return mask >= 128;
}

/** Pixels that are the person's in both masks, over those that are in either; 0 when nobody is in them. The masks have one size. */
double maskIou(const ImageGrey8& a, const ImageGrey8& b);

/** Reads image, mask and labels. NotFound, with the remedy, when the frame has no mask. */
Result<FramePicture> readFramePicture(const ScanFrame& frame);

/** A mask of undistorted pixels as pixels of the frame's files, whose lens distorts. */
ImageGrey8 toStoredPixels(const ImageGrey8& mask, const ScanFrame& frame);

}  // namespace dpl
