// SPDX-License-Identifier: Apache-2.0
// What one frame shows. Every stage that looks at pixels reads them through here.
#pragma once

#include "reconstruction/capture/scan.h"

namespace dpl {

/** Decoded, free of lens distortion, each plane of the size of the frame's camera. */
struct FramePicture {
    ImageRgb8 image;    // display-referred sRGB, background included
    ImageGrey8 mask;    // 0 … 255, person where isPerson()
    ImageGrey8 labels;  // label values; empty when the frame brings none
};

/** Whether a mask value counts as person. Soft mattes are cut here, so that half-covered pixels do not teach a translucent outline. */
constexpr bool isPerson(uint8_t mask) {
    return mask >= 128;
}

/** NotFound, with the remedy, when the frame has no mask. */
Result<FramePicture> readFramePicture(const ScanFrame& frame);

}  // namespace dpl
