// SPDX-License-Identifier: Apache-2.0
// How many triangles use each edge of a mesh. One: the edge is on a border.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include "sdk/math/types.h"

namespace dpl {

using Edge = std::pair<uint32_t, uint32_t>;  // its vertices, the lower first

inline Edge edgeOf(uint32_t a, uint32_t b) {
    return {std::min(a, b), std::max(a, b)};
}

inline std::map<Edge, int> edgeUses(std::span<const Triangle> triangles) {
    std::map<Edge, int> uses;
    for (const Triangle& t : triangles)
        for (int k = 0; k < 3; ++k) ++uses[edgeOf(t[k], t[(k + 1) % 3])];
    return uses;
}

}  // namespace dpl
