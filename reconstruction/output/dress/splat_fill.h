// SPDX-License-Identifier: Apache-2.0
// Splats for triangles of a layer that have none, or none that hides what lies behind, in the colours around them.
#pragma once

#include <cstdint>
#include <vector>

#include "reconstruction/output/dress/layer_part.h"

namespace dpl {

using Marks = std::vector<uint8_t>;                     // one per triangle: 0 or 1
using Neighbours = std::vector<std::vector<uint32_t>>;  // triangleNeighbours()

/** Replaces the splats of the triangles marked in `fill` by as many as others have for their area, in the mean colour of the triangles that
 *  are not `distrusted`, spread along the surface. Takes away those of the triangles marked in `empty`. Colours vertices of filled
 * triangles too. A filled triangle shows one side or both as its splats did. Without trusted splats it fills nothing. Returns the number of
 * filled triangles. */
uint32_t fillSplats(const Marks& fill, const Marks& empty, const Marks& distrusted, const Neighbours& neighbours, LayerPart& part);

/** Fills the triangles of a garment whose splats hide less than a third of what half of its triangles hide: there its own avatar's body lay
 *  in front of the cloth, and no picture trained it. Hems stay as they are. Returns the number of filled triangles. */
uint32_t mendGarment(LayerPart& garment);

}  // namespace dpl
