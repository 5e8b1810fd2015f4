// SPDX-License-Identifier: Apache-2.0
// The air between the legs of trousers. Where they touch in the still pose no outline shows it, so the hull joins them to one tube.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** A slab, 14 mm thick, of the points that are equally far from both legs of a posed body. It ends 2 cm below the crotch. */
class LegGap {
public:
    /** posed: the vertices of `body`, with y up. Empty for a rig that names no two upper legs, and for a body whose legs do not meet. */
    LegGap(const MeshData& body, std::span<const JointData> joints, std::span<const Vec3f> posed);

    bool empty() const { return !left_; }
    /** Metres to the slab's faces: positive within it, negative outside. Far from the legs any negative number. Safe on several threads. */
    float operator()(const Vec3f& point) const;
    /** Flags of the triangles of a mesh that lie within 3 cm of the points equally far from both legs, all corners below the slab's top. */
    std::vector<uint8_t> between(std::span<const Vec3f> positions, std::span<const Triangle> triangles) const;
    /** Brings the two walls that the slab left in a mesh together, to 2 mm, so that nothing is seen between them in the still pose.
     * Vertices stay that are not at a place `where` the slab was cut. */
    void close(SurfaceMesh& mesh, const std::function<bool(const Vec3f&)>& where) const;

private:
    std::optional<ClosestSurface> left_, right_;
    float topM_ = 0;
    Vec3f between_{0}, across_{0};  // the middle of both legs, and the level unit vector from the right to the left one
    float reachM_ = 0;              // points farther from the middle along across_ lie outside the slab

    struct Halfway {
        float sideM = 0;  // half the difference of the distances from both legs; negative nearer to the left one
        Vec3f toRight{0};
    };
    Halfway halfway(const Vec3f& point) const;
    bool near(const Vec3f& point) const;
};

}  // namespace dpl
