// SPDX-License-Identifier: Apache-2.0
// A texture atlas of a mesh: where each triangle lies in one square picture.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

constexpr uint32_t kLeastTexturePx = 256, kMostTexturePx = 8192;
/** Whether a texture may have this side: a power of two from kLeastTexturePx to kMostTexturePx. */
constexpr bool isTexturePx(uint32_t sidePx) {
    return sidePx >= kLeastTexturePx && sidePx <= kMostTexturePx && (sidePx & (sidePx - 1)) == 0;
}

/** How finely a triangle is drawn. Triangles of different kinds share no chart. */
struct AtlasKind {
    uint32_t layer = 0;
    float density = 1;  // texels a metre, relative to other triangles; above 0

    auto operator<=>(const AtlasKind&) const = default;
};

/** Texels: x to the right, y down, the centre of the first at (0.5, 0.5). */
struct MeshAtlas {
    uint32_t sidePx = 0;
    uint32_t gutterPx = 0;  // texels around each chart that belong to no other chart; charts are twice as far apart
    float texelM = 0;       // size of a texel on a chart's plane at density 1, metres
    uint32_t chartCount = 0;
    std::vector<uint32_t> chart;                // of each triangle
    std::vector<std::array<Vec2f, 3>> corners;  // of each triangle, texels
};

/** Lays out a mesh. sidePx: isTexturePx(). kind: one a triangle. Deterministic. InvalidArgument: another size, no triangles, a surface
 *  without area. Unsupported: so many charts that they do not fit at any scale; the sentence names the remedy. */
Result<MeshAtlas> layOutAtlas(std::span<const Vec3f> positions, std::span<const Triangle> triangles, std::span<const AtlasKind> kind,
                              uint32_t sidePx);

/** A mesh whose vertices have one place each in the atlas: a vertex on a border of charts is there once for each of its charts. */
struct SeamedMesh {
    MeshData mesh;              // layers and triangles in their order; vertices of no triangle are gone
    std::vector<uint32_t> old;  // V: vertex of the mesh before
    std::vector<Vec2f> uv;      // V: glTF texture coordinates, 0 to 1, v down
};
SeamedMesh splitAtSeams(const MeshData& mesh, const MeshAtlas& atlas);

}  // namespace dpl
