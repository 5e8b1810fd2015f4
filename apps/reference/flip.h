// SPDX-License-Identifier: Apache-2.0
// LDR-FLIP estimates how different two pictures look to a viewer who flips between them (Andersson et al., "FLIP: A Difference Evaluator
// for Alternating Images", 2020). Written from the paper, in double precision.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace dpl {

/** The paper's viewing conditions: a monitor 3840 px and 0.7 m wide, seen from 0.7 m. */
constexpr double kFlipPixelsPerDegree = 67.0206;

/** One value per pixel: 0 is no visible difference, 1 the largest. Pictures are display-referred (sRGB) RGB in [0,1], interleaved,
 * row-major, of one size; values outside [0,1] are clamped. Takes about a second a megapixel. */
std::vector<double> flipMap(std::span<const double> reference, std::span<const double> test, uint32_t widthPx, uint32_t heightPx,
                            double pixelsPerDegree = kFlipPixelsPerDegree);

}  // namespace dpl
