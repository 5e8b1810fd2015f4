// SPDX-License-Identifier: Apache-2.0
// The two subjects of these tests. Each is made once, because that takes seconds.
#pragma once

#include <gtest/gtest.h>

#include <map>

#include "reconstruction/subject/sample/subject.h"

namespace dpl {

inline const Subject& subject() {
    static const Subject kSubject = [] {
        Jobs jobs(2);
        return makeSubject(6, jobs);  // the hair of this seed needs a pinhole closed beside the hairline
    }();
    return kSubject;
}

inline const Subject& skirted() {
    static const Subject kSubject = [] {
        Jobs jobs(2);
        return makeSubject(6, jobs, Bottom::Skirt);
    }();
    return kSubject;
}

/** The border loops of a layer, by their vertices. Expects a manifold whose borders do not touch. */
inline std::vector<std::vector<uint32_t>> openings(const MeshData& mesh, const LayerData& layer) {
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t)
        for (int c = 0; c < 3; ++c) ++edges[{mesh.triangles[t][c], mesh.triangles[t][(c + 1) % 3]}];
    std::map<uint32_t, uint32_t> next;
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1) << layer.name;
        if (edges.contains({edge.second, edge.first})) continue;
        EXPECT_TRUE(next.try_emplace(edge.first, edge.second).second) << layer.name << ": borders touch";
    }
    std::vector<std::vector<uint32_t>> loops;
    while (!next.empty()) {
        loops.emplace_back();
        for (uint32_t v = next.begin()->first; next.contains(v);) {
            loops.back().push_back(v);
            const uint32_t to = next[v];
            next.erase(v);
            v = to;
        }
    }
    return loops;
}

}  // namespace dpl
