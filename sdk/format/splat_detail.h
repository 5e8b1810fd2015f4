// SPDX-License-Identifier: Apache-2.0
// Measures the groups of splats for level of detail when they are loaded.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"
#include "sdk/math/detail.h"

namespace dpl {

/** Splats [first, end) of a group, in file order. The second group of a chunk may be empty. */
struct GroupRange {
    uint32_t first = 0, end = 0;
    uint32_t count() const { return end - first; }
};
inline GroupRange groupRange(const CodedSplats& splats, size_t g) {
    const SplatChunk& c = splats.chunks[g / 2];
    const uint32_t first = c.firstSplat + std::min(c.splatCount, uint32_t(g % 2) * kSplatGroupSize);
    return {first, std::min(first + kSplatGroupSize, c.firstSplat + c.splatCount)};
}

/** Fills splats.groups (12 bytes per group). Parents must be triangles of the mesh. */
void measureGroups(const MeshData& mesh, CodedSplats& splats);

/** A group of general splats: kSplatGroupSize neighbours, fewer in the last group. */
struct GeneralGroup {
    Vec3f middle{0}, reach{0};  // centre and half size of the box around the splats' centres
    SplatGroup detail;
};

/** Measures the groups of general splats. order[new] = old; it must keep neighbours together (spatialOrder). */
std::vector<GeneralGroup> measureGroups(const StaticSplatData& splats, std::span<const uint32_t> order);

}  // namespace dpl
