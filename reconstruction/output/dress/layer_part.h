// SPDX-License-Identifier: Apache-2.0
// Takes an avatar's layers apart and joins layers of several avatars into one.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/subject/shape/implicit_mesh.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** A layer with all that belongs to it. Indices count from the layer's own first vertex and triangle. */
struct LayerPart {
    std::string name, role;
    MeshData mesh;                          // without layers
    SplatData splats;                       // triangleStart: one more than the part's triangles
    std::vector<glm::u16vec4> nodeIndices;  // of pose correctives; empty: none
    std::vector<glm::u8vec4> nodeWeights;

    SurfaceMesh surface() const { return {mesh.restPositions, mesh.triangles}; }
};

/** layer: an index into avatar.mesh.layers. */
LayerPart takeLayer(const AvatarData& avatar, size_t layer);

/** Replaces mesh, splats and the vertices' corrective nodes of `avatar`. Splats of a lower SH degree get zeros above it. If the avatar has
 *  correctives, each part has nodes. */
void joinLayers(std::span<const LayerPart> parts, AvatarData& avatar);

/** Moves the part to new rest positions. Its splats keep their triangle and (u, v); size and angle follow the triangle's stretch, and
 *  spherical harmonics its rotation. */
void movePart(std::vector<Vec3f> restPositions, LayerPart& part);

}  // namespace dpl
