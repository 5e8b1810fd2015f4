// SPDX-License-Identifier: Apache-2.0
// Splats for triangles of a layer that have none, or none that hides what lies behind, in the colours around them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruction/output/dress/layer_part.h"

namespace dpl {

using Marks = std::vector<uint8_t>;                     // one per triangle: 0 or 1
using Neighbours = std::vector<std::vector<uint32_t>>;  // triangleNeighbours()

/** Of each triangle the colours of its splats, each times the weight of its splat, and the sum of the weights. Display-referred, 0 to 1;
 * all zero without splats. */
std::vector<Vec4f> splatColours(const LayerPart& part);

/** Mean colours of the triangles that are not `distrusted`, spread to the others along the surface and smoothed there until they run evenly
 *  from one trusted side to the other. One per triangle. */
std::vector<Vec3f> coloursAround(const LayerPart& part, const Marks& distrusted, const Neighbours& neighbours);

/** Replaces the splats of the triangles marked in `fill` by as many as triangles that are not `distrusted` have for their area, in the
 *  colours `around`. Takes away those of the triangles marked in `empty`. Vertices between filled triangles take the colour too. A filled
 *  triangle shows one side or both as its splats did. Without trusted splats it fills nothing. Returns the number of filled triangles. */
uint32_t fillSplats(const Marks& fill, const Marks& empty, const Marks& distrusted, std::span<const Vec3f> around, LayerPart& part);

/** 1 for the marked triangles and `rings` rings of neighbours around them. */
Marks grown(Marks marked, const Neighbours& neighbours, int rings);

/** Fills those of the `uncovered` triangles of a garment whose splats hide less than a third of what half of its triangles hide: on its own
 *  avatar the body lay in front of the cloth, and no picture trained it. Hems stay as they are. Returns the number of filled triangles. */
uint32_t mendGarment(const Marks& uncovered, LayerPart& garment);

}  // namespace dpl
