// SPDX-License-Identifier: Apache-2.0
// Merges vertices at the same place. Files split vertices at seams of texture or normals; merging makes the surface connected again.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** Places are numbered from 0 in order of first appearance. */
struct MergedVertices {
    std::vector<uint32_t> placeOf;  // V: number of the vertex' place
    uint32_t count = 0;             // of places
};

/** Compares exactly. positions must be finite: NaN has no order in the map. */
inline MergedVertices mergeVertices(std::span<const Vec3f> positions) {
    std::map<std::tuple<float, float, float>, uint32_t> places;
    MergedVertices merged;
    for (const Vec3f& p : positions) merged.placeOf.push_back(places.try_emplace({p.x, p.y, p.z}, uint32_t(places.size())).first->second);
    merged.count = uint32_t(places.size());
    return merged;
}

}  // namespace dpl
