// SPDX-License-Identifier: Apache-2.0
// Mesh depth in double precision: tests the ray through an image point against every triangle (Möller and Trumbore 1997).
#pragma once

#include <span>
#include <string>

#include "apps/reference/reference_renderer.h"

namespace dpl {

/** View-space z in metres of the nearest surface beyond 0.05 m on the ray through an image point; infinite if there is none. positions:
 *  world, metres. */
double referenceMeshDepth(std::span<const glm::dvec3> positions, std::span<const glm::uvec3> triangles, const ReferenceCamera& camera,
                          const glm::dvec2& pointPx);

/** Compares a depth image (0 = no surface) with the referee's. A pixel is wrong when its depth lies outside the range that the referee
 * finds within `slackPx` of the pixel centre, widened by the relative `slack`. Rounding moves edges by less than that. */
struct MeshDepthReport {
    size_t pixels = 0, covered = 0, wrong = 0;
    size_t sharp = 0;  // pixels whose range is narrower than 1 %, where the comparison is strict
    std::string firstWrong;
};
MeshDepthReport compareMeshDepth(std::span<const float> depthM, std::span<const glm::dvec3> positions,
                                 std::span<const glm::uvec3> triangles, const ReferenceCamera& camera, double slackPx = 0.005,
                                 double slack = 1e-5);

}  // namespace dpl
