// SPDX-License-Identifier: Apache-2.0
// The depth of a mesh in double precision: a ray through a point of the image is tested against every triangle (Möller and Trumbore 1997).
#pragma once

#include <span>
#include <string>

#include "apps/reference/reference_renderer.h"

namespace dpl {

/** View z of the nearest surface beyond 0.05 m on the ray through a point of the image; infinite if there is none. positions: world. */
double referenceMeshDepth(std::span<const glm::dvec3> positions, std::span<const glm::uvec3> triangles, const ReferenceCamera& camera,
                          const glm::dvec2& pointPx);

/** A picture of depths (0 = nothing) against the referee's. A pixel is wrong when its depth lies outside the range of depths that the
 *  referee sees within `slackPx` of its centre, widened by the factor `slack`. Rounding moves edges by less than that. */
struct MeshDepthReport {
    size_t pixels = 0, covered = 0, wrong = 0;
    size_t sharp = 0;  // pixels where that range is narrower than 1 %, so that the comparison is strict
    std::string firstWrong;
};
MeshDepthReport compareMeshDepth(std::span<const float> depthM, std::span<const glm::dvec3> positions,
                                 std::span<const glm::uvec3> triangles, const ReferenceCamera& camera, double slackPx = 0.005,
                                 double slack = 1e-5);

}  // namespace dpl
