// SPDX-License-Identifier: Apache-2.0
// Projected splats as somebody else blends them, who has a GPU that this library does not know (sdk/include/doppel/doppel_splats.h).
#pragma once

#include <cstdint>

#include "sdk/math/coverage.h"

namespace dpl {

/** One splat of one view: what the CPU renderer's blending reads of it. α at a pixel is opacity·exp(−½(conicA (dx + slope dy)² +
 *  inverseVarianceY dy²)), at most kMaxAlpha and dropped below kMinAlpha. */
struct ScreenSplat {
    float x, y;                          // centre, px, pixel centres at +0.5, top left origin
    float depthM;                        // view z
    float conicA, slope;                 // px⁻²; conicB/conicA
    float inverseVarianceY;              // px⁻²
    uint16_t red, green, blue, opacity;  // 65535 is 1
};
static_assert(sizeof(ScreenSplat) == 32);

/** What a projection wrote. The splats of the second view follow those of the first one. */
struct ScreenSplats {
    uint32_t counts[2] = {};  // one a view
    uint32_t samples = 1;     // positions of a pixel at which to blend, 1 or kCoverageSamples; the mean of them is the pixel
};

}  // namespace dpl
