// SPDX-License-Identifier: Apache-2.0
// Outlines of binary pictures as points with normals, and which point of one outline belongs to which of another.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** A point on the crack between an inside and an outside pixel. */
struct ContourPoint {
    Vec2d px{0};          // pixels; middle of the shared edge
    Vec2d normal{0};      // unit, from inside to outside, smoothed over a few pixels
    uint32_t inside = 0;  // index of the inside pixel, y·width + x
};

/** All cracks of a picture in scan order. Edges of the picture are no outline: what lies beyond is unknown. */
std::vector<ContourPoint> contourPoints(std::span<const uint8_t> inside, uint32_t widthPx, uint32_t heightPx);

/** For each of `from` the nearest of `to` with a normal that agrees, or UINT32_MAX beyond reachPx. Distance counts a turn of the normal by
 * 60° as turnPx of way, so the two sides of an arm are never confused. */
std::vector<uint32_t> matchContours(std::span<const ContourPoint> from, std::span<const ContourPoint> to, double reachPx, double turnPx);

}  // namespace dpl
