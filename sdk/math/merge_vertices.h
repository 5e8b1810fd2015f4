// SPDX-License-Identifier: Apache-2.0
// Vertices at the same place are one: seams of texture or normals do not cut a surface.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** For every vertex the number of its place; places are numbered from 0 in the order in which they first appear. */
struct MergedVertices {
    std::vector<uint32_t> placeOf;  // V
    uint32_t count = 0;
};

/** positions must be finite. */
inline MergedVertices mergeVertices(std::span<const Vec3f> positions) {
    std::map<std::tuple<float, float, float>, uint32_t> places;
    MergedVertices merged;
    for (const Vec3f& p : positions) merged.placeOf.push_back(places.try_emplace({p.x, p.y, p.z}, uint32_t(places.size())).first->second);
    merged.count = uint32_t(places.size());
    return merged;
}

}  // namespace dpl
