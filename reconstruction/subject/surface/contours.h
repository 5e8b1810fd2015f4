// SPDX-License-Identifier: Apache-2.0
// Extracts outlines of binary pictures as points with normals, and matches the points of two outlines.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** The middle of the edge between an inside and an outside pixel. */
struct ContourPoint {
    Vec2d px{0};          // pixels
    Vec2d normal{0};      // unit, from inside to outside, smoothed over a few pixels
    uint32_t inside = 0;  // index of the inside pixel, y·width + x
};

/** The outline of a picture in scan order. The picture's border is not part of it, because nothing is known beyond it. */
std::vector<ContourPoint> contourPoints(std::span<const uint8_t> inside, uint32_t widthPx, uint32_t heightPx);

/** For each point of `from` the index of the nearest point of `to`. UINT32_MAX when none lies within reachPx, or when the normal of the
 *  nearest differs by 90° or more. The distance adds turnPx for normals that differ by 60°, so that the two sides of an arm are not
 *  confused. */
std::vector<uint32_t> matchContours(std::span<const ContourPoint> from, std::span<const ContourPoint> to, double reachPx, double turnPx);

}  // namespace dpl
