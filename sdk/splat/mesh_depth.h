// SPDX-License-Identifier: Apache-2.0
// Depth of a mesh at pixel centres, on the CPU. shaders/passes/mesh_depth does the same on the GPU, with the same formulas in the same
// order.
//
// A vertex (x, y, z) in view space has the homogeneous image position (u, v) = (fx x + cx z, fy y + cy z). Its offset from a pixel centre
// p, times its depth, is (u − z px, v − z py). With the offsets of the three corners, the edge terms are e_0 = u1 v2 − u2 v1 and so on. The
// ray through p meets the triangle when all e_i have one sign, and e_i / Σ e are the barycentric coordinates in space (Olano and Greer
// 1997). So z = Σ e_i z_i / Σ e_i is perspective correct and stays within the corners' range. It also holds for triangles that cross the
// near plane or reach behind the eye, so nothing is clipped; depths up to kNearM are dropped per pixel. No gaps between triangles that
// share an edge: corners are taken in order of their index, and edges count as inside.
#pragma once

#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/math/placement.h"

namespace dpl {

class MeshDepth {
public:
    /** depthM: resized to width × height, row-major, top row first; view z in metres of the nearest surface beyond kNearM, 0 = none.
     * positions: in the space of the view's subject; triangles index them, and both sides are drawn. Triangles with corners that are not
     * finite are left out; one that is seen edge-on may draw some of its pixels. The result does not depend on threads or on the order of
     * triangles. A warm call allocates nothing. */
    void draw(Jobs& jobs, std::span<const Vec3f> positions, std::span<const Triangle> triangles, const SubjectView& view,
              std::vector<float>& depthM);
    uint64_t bytes() const { return corners_.capacity() * sizeof(Vec3f) + boxes_.capacity() * sizeof(PixelBox); }

private:
    struct PixelBox {  // [x0, x1) × [y0, y1)
        uint16_t x0, x1, y0, y1;
    };
    static PixelBox boxOf(const Vec3f (&corners)[3], uint32_t widthPx, uint32_t heightPx);

    std::vector<Vec3f> corners_;  // (u, v, z) of every vertex
    std::vector<PixelBox> boxes_;
};

}  // namespace dpl
