// SPDX-License-Identifier: Apache-2.0
// The depth of a mesh in double precision: a ray through a point of the image against every triangle (Möller and Trumbore 1997), nothing
// else.
#pragma once

#include <span>
#include <string>

#include "tests/reference/reference_renderer.h"

namespace dpl {

/** View z of the nearest surface beyond 0.05 m on the ray through a point of the image; infinite where there is none. positions: world. */
double referenceMeshDepth(std::span<const glm::dvec3> positions, std::span<const glm::uvec3> triangles, const ReferenceCamera& camera,
                          const glm::dvec2& pointPx);

/** How a picture of depths (0 = nothing) lies to the referee's. A pixel is wrong when its depth lies outside what the referee sees within
 * `slackPx` of its centre, give or take `slack` times that: rounding moves edges by less, and elsewhere the depths there differ by less
 * than the eye of this needle. */
struct MeshDepthReport {
    size_t pixels = 0, covered = 0, wrong = 0;
    size_t sharp = 0;  // where the referee's depths around the centre differ by less than 1 %: there the comparison says something
    std::string firstWrong;
};
MeshDepthReport compareMeshDepth(std::span<const float> depthM, std::span<const glm::dvec3> positions,
                                 std::span<const glm::uvec3> triangles, const ReferenceCamera& camera, double slackPx = 0.005,
                                 double slack = 1e-5);

}  // namespace dpl
