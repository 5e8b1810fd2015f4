// SPDX-License-Identifier: Apache-2.0
// What an open garment covers: how far a point lies above or below it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "reconstruction/subject/shape/closest_surface.h"
#include "reconstruction/subject/shape/implicit_mesh.h"

namespace dpl {

/** A garment as others meet it. Copies what it needs. Queries are const and may run on several threads. */
class GarmentCover {
public:
    explicit GarmentCover(const SurfaceMesh& garment);

    struct Height {
        float aboveM = 0;  // along the garment's normal; negative below
        Vec3f normal{0};   // of the garment, unit
    };
    /** Height of a surface point with the given unit normal over the garment. None where no part of the garment within 5 cm faces the same
     *  way, or where the point lies beside the garment's border. */
    std::optional<Height> heightOf(const Vec3f& point, const Vec3f& normal) const;

    /** Which edges and corners of a triangle lie on the garment's border. Edge k runs from corner k to the next one. */
    struct Border {
        std::array<bool, 3> edge{}, corner{};
    };

private:
    ClosestSurface surface_;
    std::vector<Border> borders_;  // per triangle
};

}  // namespace dpl
