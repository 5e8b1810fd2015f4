// SPDX-License-Identifier: Apache-2.0
// Soft edges for masks that a network or a hard cut left coarse.
#pragma once

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** The mask with a soft alpha in a band of `bandPx` pixels on both sides of its edge (value 128), found by a guided filter with the picture
 *  as guide (docs/reference/observations.md). Outside the band the mask becomes 0 or 255. A mask of another size than the image is returned
 * as it is. */
ImageGrey8 refineMatte(const ImageRgb8& image, const ImageGrey8& mask, int bandPx);

}  // namespace dpl
