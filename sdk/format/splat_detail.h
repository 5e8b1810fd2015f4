// SPDX-License-Identifier: Apache-2.0
// What level of detail needs to know of splats, made when they are loaded.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/math/detail.h"

namespace dpl {

/** Splats [first, end) of half-chunk g, in file order; a chunk's second half may be empty. */
struct GroupRange {
    uint32_t first = 0, end = 0;
    uint32_t count() const { return end - first; }
};
inline GroupRange groupRange(const CodedSplats& splats, size_t g) {
    const SplatChunk& c = splats.chunks[g / 2];
    const uint32_t first = c.firstSplat + std::min(c.splatCount, uint32_t(g % 2) * kSplatGroupSize);
    return {first, std::min(first + kSplatGroupSize, c.firstSplat + c.splatCount)};
}

/** Fills splats.groups (12 bytes a half-chunk). Parents must lie within the mesh. */
void measureGroups(const MeshData& mesh, CodedSplats& splats);

/** kSplatGroupSize neighbours of general splats, the last ones fewer. */
struct GeneralGroup {
    Vec3f middle{0}, reach{0};  // of the box about their centres; half its size
    SplatGroup detail;
};

/** Of general splats in an order that keeps neighbours together (spatialOrder); order[new] = old. */
std::vector<GeneralGroup> measureGroups(const StaticSplatData& splats, std::span<const uint32_t> order);

}  // namespace dpl
