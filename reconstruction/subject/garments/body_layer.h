// SPDX-License-Identifier: Apache-2.0
// The body below the clothes: the fitted shape, with the surface's offsets only where skin was seen, and nowhere outside a garment.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Offsets times a factor that is 1 where skin was seen and falls smoothly to 0 before clothes begin. skin: per vertex, how sure the
 * pictures are that it is skin, 0 to 1. Errors: LargeSteps refuses the mesh. */
Result<std::vector<Vec3f>> skinOffsets(const MeshData& body, std::span<const Vec3f> offsets, std::span<const float> skin);

/** Moves vertices of the posed body that are not at least depthM below a garment which covers them, along the garment's normal. Neighbours
 *  follow smoothly. Returns the displacements, one per vertex, in the posed space. */
Result<std::vector<Vec3f>> pushBelow(std::span<const Vec3f> posedBody, std::span<const Triangle> triangles,
                                     std::span<const SurfaceMesh> garments, float depthM);

}  // namespace dpl
