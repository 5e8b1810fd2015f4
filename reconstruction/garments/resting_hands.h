// SPDX-License-Identifier: Apache-2.0
// Keeps cloth from following a hand that only rests on it.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/shape/closest_surface.h"
#include "reconstruction/shape/implicit_mesh.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Vertices of `piece` in the reach of a hand or forearm that it does not clothe: the cloth there is not connected to cloth on the same
 *  upper arm. Trousers below a hand on the hip are an example. A piece that lies on hands and forearms for the most part, such as gloves,
 *  has none. Empty for a rig without named arms. below: bodyBelow(piece). */
std::vector<uint32_t> clothUnderRestingHands(const SurfaceMesh& piece, std::span<const SurfacePoint> below, const MeshData& body,
                                             std::span<const JointData> joints);

/** Numbers of the body's triangles that no arm moves, from the upper arms down. All of them for a rig without named arms. */
std::vector<uint32_t> trianglesWithoutArms(const MeshData& body, std::span<const JointData> joints);

}  // namespace dpl
