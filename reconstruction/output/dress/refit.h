// SPDX-License-Identifier: Apache-2.0
// Refits a garment to another body of the same mesh (docs/reference/dress.md).
#pragma once

#include <span>
#include <vector>

#include "reconstruction/subject/garments/garment_cover.h"
#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/core/result.h"

namespace dpl {

/** A garment on its new body, before collisions. */
struct CarriedGarment {
    std::vector<Vec3f> positions;   // rest pose of the new body, metres
    std::vector<float> clearanceM;  // distance that each vertex shall keep from the body: what it kept from the old one, within limits
};

/** Carries a garment with the surface of the body that it covers. Each vertex keeps its place in the frame of the closest body point that
 *  faces the same way; the displacements then follow the body closely where cloth lies on it and are nearly harmonic where it hangs free
 *  (followBody). oldBody and newBody: vertices of the two bodies at rest, with the same triangles. The same body gives the same garment.
 *  Errors: as followBody. */
Result<CarriedGarment> carryGarment(const SurfaceMesh& garment, std::span<const Vec3f> oldBody, std::span<const Vec3f> newBody,
                                    std::span<const Triangle> bodyTriangles);

/** What a garment must not meet, all at rest. */
struct Obstacles {
    const ClosestSurface& body;
    std::vector<GarmentCover> below;  // garments that it goes over
    std::vector<GarmentCover> above;  // garments that it goes under; the body comes first
    std::vector<uint8_t> tucked;      // per vertex: 1 if it may lie on either side of other garments
};

/** Pushes vertices out of the obstacles. The first rounds move whole neighbourhoods, so that the garment stays smooth; the last ones move
 *  what is left by itself. clearanceM: one per vertex. Returns the number of vertices that still lie inside the body. Errors: LargeSteps
 *  refuses the mesh. */
Result<uint32_t> pushOut(const Obstacles& obstacles, std::span<const float> clearanceM, SurfaceMesh& garment);

}  // namespace dpl
