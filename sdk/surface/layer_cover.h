// SPDX-License-Identifier: Apache-2.0
// What lies below a layer, to tell whether it can be left out.
#pragma once

#include <span>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** Areas of a layer at rest, by what a look along the inward normal meets behind it within kBelowM. */
struct LayerCover {
    double shownM2 = 0;  // the outside of another layer
    double bareM2 = 0;   // the part of it where neither that triangle nor a neighbour carries splats
};
constexpr double kBelowM = 0.3;
/** A layer may be left out if no more than this share of what shows then is bare. Hems and gaps between splats take about half of it. */
constexpr double kMostBare = 0.05;

/** carries: one a triangle: whether it carries splats. leftOut: one a triangle, or empty: triangles of other layers that are not there.
 *  Takes tens of milliseconds. The mesh must have passed checkMesh. */
LayerCover coverBelow(const MeshData& mesh, size_t layer, std::span<const uint8_t> carries, std::span<const uint8_t> leftOut);

}  // namespace dpl
