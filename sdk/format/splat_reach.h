// SPDX-License-Identifier: Apache-2.0
// How far the splats of each triangle reach from it: what culling asks before anything is decoded.
#pragma once

#include <vector>

#include "sdk/format/coded_splats.h"

namespace dpl {

/** Of one triangle at rest. A splat is below 1/255 beyond √level · σ, level = 2 ln(255 α). */
struct TriangleReach {
    float reachM = 0;                          // largest √level · standard deviation of its splats
    float rootLevel = 0;                       // largest √level
    uint32_t freeSplats = 0, gatedSplats = 0;  // that show both faces, one face
    bool overshoots = false;                   // a splat that can be seen has its centre off the triangle
};

/** Scales and opacities as decodeSplats gives them, but for float rounding (1e-5). Parents must lie within the triangles. */
std::vector<TriangleReach> reachOfTriangles(const CodedSplats& splats, size_t triangles);

}  // namespace dpl
