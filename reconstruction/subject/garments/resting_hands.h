// SPDX-License-Identifier: Apache-2.0
// Keeps cloth from following a hand that only rests on it, and from being joined to the sleeve of that hand.
#pragma once

#include <span>
#include <vector>

#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** bodyBelow() of a garment, but cloth in the reach of a forearm or hand that it does not clothe gets a point of the body without arms.
 *  Cloth clothes them where it is connected, over cloth on the same arm, to cloth on the upper arm. Trousers below a hand on the hip do
 * not. A piece that lies on forearms and hands for the most part, such as gloves, does. Without named arms: bodyBelow(). piece and
 * posedBody (V positions of `body`) are in the same pose. */
std::vector<SurfacePoint> wornBodyBelow(const SurfaceMesh& piece, const MeshData& body, std::span<const JointData> joints,
                                        std::span<const Vec3f> posedBody);

/** A garment and wornBodyBelow() of each of its vertices. */
struct WornPiece {
    SurfaceMesh mesh;
    std::vector<SurfacePoint> below;
};

/** Parts the sleeve or glove of a forearm or hand from cloth on anything but that arm. The hull cannot tell touching from joined: where a
 *  hand lies on the hip, sleeve and hip are one surface, which would span both in every other pose. Where a triangle joins them, its
 *  corners on the arm are doubled and go with the hip, so the pose of the scan has no gap. Cloth on an upper arm stays joined to trunk and
 *  forearm. Cloth that faces one way along a forearm is no sleeve but something that hangs over it, and stays whole. */
WornPiece withArmsApart(const SurfaceMesh& piece, const MeshData& body, std::span<const JointData> joints,
                        std::span<const Vec3f> posedBody);

}  // namespace dpl
