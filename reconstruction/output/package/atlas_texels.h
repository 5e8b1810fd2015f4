// SPDX-License-Identifier: Apache-2.0
// The texels that the charts of an atlas cover.
#pragma once

#include "reconstruction/output/package/mesh_atlas.h"

namespace dpl {

struct AtlasTexel {
    uint32_t pixel;
    Vec2f barycentric;  // of corners 1 and 2
};

/** Texels by triangle: those of t are [start[t], start[t + 1]). A texel belongs to the first triangle that covers its centre. */
struct AtlasTexels {
    std::vector<AtlasTexel> all;
    std::vector<uint32_t> start{0};

    explicit AtlasTexels(const MeshAtlas& atlas);
};

}  // namespace dpl
