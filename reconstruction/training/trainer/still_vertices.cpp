// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/still_vertices.h"

namespace dpl {

void holdBareVertices(const MeshData& mesh, const TrainableSplats& splats, PoseCorrectiveData& c) {
    if (c.empty()) return;
    std::vector<uint8_t> carries(mesh.restPositions.size(), 0);
    for (const uint32_t triangle : splats.triangle)
        for (int k = 0; k < 3; ++k) carries[mesh.triangles[triangle][k]] = 1;
    const auto zeroNode = uint16_t(c.nodeCount);
    ++c.nodeCount;
    c.nodes.resize(size_t(c.nodeCount) * c.columnCount(), Vec4f(0));
    const size_t body = mesh.layers.empty() ? carries.size() : mesh.layers.front().vertexCount;
    for (size_t v = 0; v < body; ++v)
        if (!carries[v]) c.nodeIndices[v] = glm::u16vec4(zeroNode), c.nodeWeights[v] = {255, 0, 0, 0};
}

}  // namespace dpl
