// SPDX-License-Identifier: Apache-2.0
// Draws triangles as Metal does: pixel centres or Metal's four sample positions, the top-left rule, the first vertex gives flat values,
// blending and depth test. No clipping at the planes of the view volume: vertices must lie in front of the eye.
#pragma once

#include <string>
#include <vector>

#include "tests/metal/software/texture.h"

namespace dpl::mtl {

struct ColourTarget {
    Pixels* pixels = nullptr;  // none: no attachment
    uint32_t slice = 0;
    PipelineColour how;
};

struct Draw {
    const msl::Entry* vertex = nullptr;
    const msl::Entry* fragment = nullptr;
    msl::Bindings vertexBindings, fragmentBindings;
    PrimitiveType type = PrimitiveType::Triangle;
    uint32_t firstVertex = 0, vertices = 0, firstInstance = 0, instances = 0;
    double viewX = 0, viewY = 0, viewWidthPx = 0, viewHeightPx = 0;
    ColourTarget colours[2];
    Pixels* depth = nullptr;
    uint32_t depthSlice = 0;
    CompareFunction nearer = CompareFunction::Always;
    bool writesDepth = false;
    uint32_t layers = 0;  // of layered rendering; 0: none
    uint32_t samples = 1;
};

void draw(const Draw& draw, std::vector<std::string>& faults);

}  // namespace dpl::mtl
