// SPDX-License-Identifier: Apache-2.0
// The closest point on a triangle mesh, and whether a point lies inside it.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

struct SurfacePoint {
    uint32_t triangle = UINT32_MAX;  // UINT32_MAX: none within reach
    Vec3f barycentric{0};            // of the triangle's corners; sums to 1
    Vec3f position{0};
    float distanceM = std::numeric_limits<float>::infinity();

    bool found() const { return triangle != UINT32_MAX; }
};

/** A tree of boxes over the triangles of a mesh. Copies what it needs. Queries are const and may run on several threads; move() may not run
 *  beside them. */
class ClosestSurface {
public:
    ClosestSurface(std::span<const Vec3f> positions, std::span<const Triangle> triangles);

    /** The same triangles at other positions (of all vertices, as in the constructor). Keeps the tree, so it is several times as fast as a
     *  new one, and queries are slower the more the mesh is bent. */
    void move(std::span<const Vec3f> positions);

    /** The closest point within reachM. Of equally close triangles the lower index wins. */
    SurfacePoint find(const Vec3f& point, float reachM = std::numeric_limits<float>::infinity()) const;
    /** The closest point among triangles whose unit normal n has dot(n, normal) ≥ minCosine. */
    SurfacePoint findFacing(const Vec3f& point, const Vec3f& normal, float minCosine,
                            float reachM = std::numeric_limits<float>::infinity()) const;

    /** Unit normal at a found point, interpolated between the vertices. */
    Vec3f normalAt(const SurfacePoint& at) const;
    /** Whether `point` lies inside, by `closest`, the surface point that find() gave for it. */
    bool isInside(const Vec3f& point, const SurfacePoint& closest) const {
        return glm::dot(point - closest.position, normalAt(closest)) < 0;
    }
    /** Distance from the surface, negative inside; positive infinity beyond reachM. The surface should be closed near the point. */
    float signedDistance(const Vec3f& point, float reachM) const;

private:
    struct Node {
        Vec3f low, high;
        uint32_t first = 0, count = 0;  // a leaf's triangles in order_; count 0: an inner node with children `first` and first + 1
    };
    std::vector<Vec3f> positions_, vertexNormals_, faceNormals_;
    std::vector<Triangle> triangles_;
    std::vector<uint32_t> order_;
    std::vector<Node> nodes_;

    void findNormals();
    void build(uint32_t node, uint32_t first, uint32_t count, const std::vector<Vec3f>& centres);
    template <class Accept>
    SurfacePoint search(const Vec3f& point, float reachM, Accept accept) const;
};

}  // namespace dpl
