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

}  // namespace dpl
