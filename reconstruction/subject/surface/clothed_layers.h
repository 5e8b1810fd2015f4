// SPDX-License-Identifier: Apache-2.0
// The body and the garments among the layers of a mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** The first layer with the role "body"; null without one. */
inline const LayerData* bodyLayer(const MeshData& mesh) {
    for (const LayerData& layer : mesh.layers)
        if (layer.role == "body") return &layer;
    return nullptr;
}

/** The vertices of all layers with the role "garment". Ascending where layers are in order. */
inline std::vector<uint32_t> garmentVertices(const MeshData& mesh) {
    std::vector<uint32_t> vertices;
    for (const LayerData& layer : mesh.layers)
        for (uint32_t v = 0; layer.role == "garment" && v < layer.vertexCount; ++v) vertices.push_back(layer.firstVertex + v);
    return vertices;
}

}  // namespace dpl
