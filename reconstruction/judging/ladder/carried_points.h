// SPDX-License-Identifier: Apache-2.0
// Points that a surface carries: bound to the nearest triangle in one pose, moved with it in others.
#pragma once

#include <span>
#include <vector>

#include "sdk/core/jobs.h"
#include "sdk/math/types.h"

namespace dpl {

class CarriedPoints {
public:
    /** Binds `points` (with unit normals, one a point) to the nearest of the triangles that `allowed` marks (one byte a triangle). A
     *  triangle that faces away from the point's normal counts only if no other is left. At least one triangle must be allowed. */
    CarriedPoints(std::span<const Vec3f> points, std::span<const Vec3f> normals, std::span<const Vec3f> surface,
                  std::span<const Triangle> triangles, std::span<const uint8_t> allowed, Jobs& jobs);

    /** Takes, for each point, its mean place in the frame of its triangle over several poses; weigh in one pose with each call. The place
     *  from the constructor counts as none. */
    void average(std::span<const Vec3f> points, std::span<const Vec3f> surface);

    /** The points on the surface in another pose. */
    std::vector<Vec3f> at(std::span<const Vec3f> surface) const;

    /** The places of the surface that carry the points, without the distances from them, in another pose. */
    std::vector<Vec3f> places(std::span<const Vec3f> surface) const;

    /** Distances from the points to their triangles, metres. */
    std::vector<float> distancesM() const;

private:
    struct Anchor {
        Triangle corners;
        Vec2d uv{0};     // nearest point of the triangle, barycentric of corners 1 and 2
        Vec3d place{0};  // of the point, from that nearest point, in the triangle's frame [T1 T2 N]
    };
    std::vector<Anchor> anchors_;
    uint32_t averaged_ = 0;
};

}  // namespace dpl
