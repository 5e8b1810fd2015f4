// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/check_mesh.h"

#include <cmath>

namespace dpl {

Status checkMesh(const MeshData& mesh, size_t jointCount) {
    const size_t vertices = mesh.restPositions.size();
    if (mesh.jointIndices.size() != vertices || mesh.jointWeights.size() != vertices)
        return fail(Code::InvalidArgument, "the mesh has {} vertices, {} joint indices and {} skin weights; every vertex needs both",
                    vertices, mesh.jointIndices.size(), mesh.jointWeights.size());
    for (size_t v = 0; v < vertices; ++v)
        for (int k = 0; k < 4; ++k)
            if (mesh.jointWeights[v][k] != 0 && mesh.jointIndices[v][k] >= jointCount)
                return fail(Code::InvalidArgument, "vertex {} follows joint {}; the rig has {}", v, mesh.jointIndices[v][k], jointCount);
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
            if (mesh.triangles[t][k] >= vertices)
                return fail(Code::InvalidArgument, "triangle {} names vertex {}; the mesh has {}", t, mesh.triangles[t][k], vertices);
    return {};
}

Status checkFinite(const MeshData& mesh) {
    for (size_t v = 0; v < mesh.restPositions.size(); ++v) {
        const Vec3f& p = mesh.restPositions[v];
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return fail(Code::InvalidArgument, "vertex {} is not at a finite place: [{}, {}, {}]", v, p.x, p.y, p.z);
    }
    return {};
}

Status checkLayers(const MeshData& mesh) {
    uint32_t vertex = 0, triangle = 0;
    if (mesh.layers.size() > 256) return fail(Code::InvalidArgument, "{} layers, at most 256 are possible", mesh.layers.size());
    for (const LayerData& layer : mesh.layers) {
        if (layer.firstVertex != vertex || layer.firstTriangle != triangle)
            return fail(Code::InvalidArgument, "layer '{}' does not begin where the layer before it ends", layer.name);
        if (layer.vertexCount == 0 || layer.triangleCount == 0)
            return fail(Code::InvalidArgument, "layer '{}' has no vertices or no triangles", layer.name);
        if (layer.role != "body" && layer.role != "garment" && layer.role != "hair")
            return fail(Code::InvalidArgument, "layer '{}' has the role '{}': body, garment or hair is meant", layer.name, layer.role);
        if (layer.vertexCount > mesh.restPositions.size() - vertex || layer.triangleCount > mesh.triangles.size() - triangle)
            return fail(Code::InvalidArgument, "layer '{}' reaches past the mesh", layer.name);
        if (layer.vertexCount > uint64_t(layer.triangleCount) * 3)  // Draco refuses to decode such a mesh
            return fail(Code::InvalidArgument, "layer '{}' has {} vertices that no triangle can name; drop unused vertices", layer.name,
                        layer.vertexCount - layer.triangleCount * 3);
        for (uint32_t t = 0; t < layer.triangleCount; ++t)
            for (int k = 0; k < 3; ++k) {
                const uint32_t index = mesh.triangles[triangle + t][k];
                if (index < vertex || index - vertex >= layer.vertexCount)
                    return fail(Code::InvalidArgument, "triangle {} names vertex {} outside its layer '{}'", triangle + t, index,
                                layer.name);
            }
        vertex += layer.vertexCount, triangle += layer.triangleCount;
    }
    if (vertex != mesh.restPositions.size() || triangle != mesh.triangles.size())
        return fail(Code::InvalidArgument, "layers cover {} of {} vertices and {} of {} triangles", vertex, mesh.restPositions.size(),
                    triangle, mesh.triangles.size());
    return {};
}

}  // namespace dpl
