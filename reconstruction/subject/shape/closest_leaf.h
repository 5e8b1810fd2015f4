// SPDX-License-Identifier: Apache-2.0
// The leaf of ClosestSurface's tree: up to eight triangles, side by side for vectors. Private to reconstruction/subject/shape.
#pragma once

#include <cstdint>

#include "sdk/math/types.h"

namespace dpl {

constexpr uint32_t kLeafTriangles = 8;

struct alignas(32) ClosestLeaf {
    float corner[3][3][kLeafTriangles] = {};  // by corner and axis; unused lanes are zero
};

/** The closest points of the triangles of a leaf. */
struct alignas(32) LeafPoints {
    float weight[3][kLeafTriangles];  // barycentric
    float distance2[kLeafTriangles];
};

/** Barycentric coordinates of the point of each triangle that is closest to p, by the Voronoi regions of its features (Ericson 2005,
 *  Real-Time Collision Detection, 5.1.5), and its squared distance. The same bits on every instruction set. */
void closestInLeaf(const ClosestLeaf& leaf, const Vec3f& p, LeafPoints& out);

}  // namespace dpl
