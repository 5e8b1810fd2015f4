// SPDX-License-Identifier: Apache-2.0
// Disjoint sets of vertices, to find the connected pieces of a mesh.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

class VertexSets {
public:
    /** Each vertex is a set of its own. */
    explicit VertexSets(size_t vertexCount) : root_(vertexCount) { std::iota(root_.begin(), root_.end(), 0u); }
    /** The vertices of each triangle are in one set. */
    VertexSets(size_t vertexCount, std::span<const Triangle> triangles) : VertexSets(vertexCount) {
        for (const Triangle& t : triangles) join(t.x, t.y), join(t.y, t.z);
    }

    /** The lowest vertex of the vertex' set. */
    uint32_t find(uint32_t vertex) {
        while (root_[vertex] != vertex) vertex = root_[vertex] = root_[root_[vertex]];
        return vertex;
    }
    void join(uint32_t a, uint32_t b) {
        a = find(a), b = find(b);
        root_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<uint32_t> root_;
};

}  // namespace dpl
