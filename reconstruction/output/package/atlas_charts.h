// SPDX-License-Identifier: Apache-2.0
// Cuts a surface into charts: parts that a parallel projection lays flat without folds.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** A part of a surface. A point p of it lies at (p·across, p·up) of its plane, metres. */
struct AtlasChart {
    std::vector<uint32_t> triangles;
    Vec3f across{1, 0, 0}, up{0, 1, 0};  // unit, at right angles; across × up points outwards

    Vec2f place(const Vec3f& p) const { return {glm::dot(p, across), glm::dot(p, up)}; }
};

/** Charts that cover every triangle once. A chart is of one group, its triangles lie within 72° of its plane, and no two of them cover the
 *  same place of it. Charts grow over shared edges, the flattest neighbour first, so borders lie along folds. They are turned so that
 *  their box is small and not higher than wide. Triangles without area may lie in any chart of their group. group: one a triangle.
 *  Deterministic. */
std::vector<AtlasChart> chartsOf(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::span<const uint32_t> group);

}  // namespace dpl
