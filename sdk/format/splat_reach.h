// SPDX-License-Identifier: Apache-2.0
// Bounds how far the splats of each triangle reach, so that culling needs no decoded splats.
#pragma once

#include <vector>

#include "sdk/format/coded_splats.h"

namespace dpl {

/** Bounds for one triangle at rest. Beyond √level · σ with level = 2 ln(255 α), a splat of opacity α adds less than 1/255. */
struct TriangleReach {
    float reachM = 0;               // largest √level · standard deviation of its splats
    float rootLevel = 0;            // largest √level
    uint32_t freeSplats = 0;        // splats visible from both sides
    uint32_t gatedSplats : 31 = 0;  // single-face splats
    uint32_t overshoots : 1 = 0;    // a visible splat has its centre outside the triangle
};
static_assert(sizeof(TriangleReach) == 16, "a clothed avatar has 54,000 of them at the peak of its load");

/** Uses scales and opacities as decodeSplats gives them, up to float rounding (1e-5). Parents must be below `triangles`. */
std::vector<TriangleReach> reachOfTriangles(const CodedSplats& splats, size_t triangles);

}  // namespace dpl
