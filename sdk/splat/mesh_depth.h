// SPDX-License-Identifier: Apache-2.0
// Depth of a mesh at pixel centres, on the CPU. The GPU's twin is shaders/passes/mesh_depth: the same formulas in the same order.
//
// With a vertex in view space (x, y, z), (u, v) = (fx x + cx z, fy y + cy z) and its offset from a pixel centre p scaled by its depth is (u
// - z px, v - z py). The ray through p meets the triangle where the three edge terms e = u1 v2 - u2 v1 of those offsets have one sign, and
// e over their sum are the barycentric coordinates in space (Olano and Greer 1997). So z = Σ e_i z_i / Σ e_i is perspective correct, never
// leaves the corners' range, and holds for triangles that reach through the near plane or behind the eye, which need no clipping: what is
// not beyond kNearM is not there. Corners are taken in order of their index and edges count as inside: triangles that share an edge leave
// no gap.
#pragma once

#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/math/camera.h"

namespace dpl {

class MeshDepth {
public:
    /** depthM: resized to width × height, row by row, top first: view z in metres of the nearest surface beyond kNearM, both sides of a
     * triangle count; 0 = none. positions: world. Triangle indices are those of `positions`. Triangles with corners that are not finite are
     * not there; of triangles seen edge-on at most points of theirs. Does not depend on threads or the order of triangles. A warm call
     * allocates nothing. */
    void draw(Jobs& jobs, std::span<const Vec3f> positions, std::span<const Triangle> triangles, const Cameraf& camera,
              std::vector<float>& depthM);
    uint64_t bytes() const { return corners_.capacity() * sizeof(Vec3f) + boxes_.capacity() * sizeof(PixelBox); }

private:
    struct PixelBox {  // [x0, x1) × [y0, y1)
        uint16_t x0, x1, y0, y1;
    };
    static PixelBox boxOf(const Vec3f (&corners)[3], uint32_t widthPx, uint32_t heightPx);

    std::vector<Vec3f> corners_;  // (u, v, z) a vertex
    std::vector<PixelBox> boxes_;
};

}  // namespace dpl
