// SPDX-License-Identifier: Apache-2.0
// How values given on the body spread over a garment: close to the body's where cloth lies on it, close to harmonic where it hangs free.
//
// The values x minimise  Σ_v (e / ℓ_v)² |x_v − b_v|² + Σ_edges |x_v − x_w|²  with b from the body, e the mean edge and
// ℓ_v = max(kClothContactM, kClothHang · distance from the body). docs/reference/garments.md
#pragma once

#include <span>
#include <vector>

#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/result.h"

namespace dpl {

/** For each vertex of `piece` the closest body point that faces the same way, so that an arm beside the torso does not take the torso's.
 *  Where none lies within half a metre: the closest body point. The piece and the body are in the same pose. */
std::vector<SurfacePoint> bodyBelow(const SurfaceMesh& piece, const ClosestSurface& body);

/** ℓ of each vertex, metres. below: bodyBelow(piece). */
std::vector<double> followLengths(std::span<const SurfacePoint> below);

/** Solves for x. lengthsM: ℓ, V values. values: b, V rows of `columns`. Returns V rows of `columns`. Errors: InvalidArgument for a piece
 *  without edges; Internal when the sparse solve fails. */
Result<std::vector<double>> followBody(const SurfaceMesh& piece, std::span<const double> lengthsM, std::span<const double> values,
                                       size_t columns);

}  // namespace dpl
