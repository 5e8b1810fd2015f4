// SPDX-License-Identifier: Apache-2.0
// Distances along a surface.
#pragma once

#include <cstdint>
#include <map>
#include <queue>
#include <span>
#include <vector>

#include "sdk/math/merge_vertices.h"
#include "sdk/math/types.h"

namespace dpl {

/** The mesh as a graph with edge lengths. Vertices at one position are merged. */
struct SurfaceGraph {
    std::vector<uint32_t> mergedOf;
    std::vector<std::vector<std::pair<uint32_t, float>>> neighbours;

    SurfaceGraph(std::span<const Vec3f> positions, std::span<const Triangle> triangles) {
        MergedVertices merged = mergeVertices(positions);
        mergedOf = std::move(merged.placeOf);
        neighbours.resize(merged.count);
        for (const Triangle& t : triangles)
            for (int c = 0; c < 3; ++c) {
                const uint32_t a = t[c], b = t[(c + 1) % 3];
                if (mergedOf[a] == mergedOf[b]) continue;
                const float length = glm::length(positions[a] - positions[b]);
                neighbours[mergedOf[a]].emplace_back(mergedOf[b], length), neighbours[mergedOf[b]].emplace_back(mergedOf[a], length);
            }
    }

    /** Dijkstra from `source`; visit(vertex, distance) returns false to stop the search at that vertex. */
    template <class Visit>
    void search(uint32_t source, std::map<uint32_t, float>& settled, Visit&& visit) const {
        using Entry = std::pair<float, uint32_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
        settled.clear();
        open.push({0.0f, source});
        while (!open.empty()) {
            const auto [distance, v] = open.top();
            open.pop();
            if (!settled.try_emplace(v, distance).second || !visit(v, distance)) continue;
            for (const auto& [to, length] : neighbours[v])
                if (!settled.contains(to)) open.push({distance + length, to});
        }
    }
};

}  // namespace dpl
