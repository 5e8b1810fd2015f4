// SPDX-License-Identifier: Apache-2.0
#include "sdk/visibility/kept_splats.h"

namespace dpl {

void keepSplats(std::span<const SplatChunk> chunks, std::span<const SplatGroup> groups, const SplatDetail& detail,
                std::vector<KeptSplat>& out) {
    for (size_t g = 0; g < groups.size(); ++g) {
        const SplatChunk& c = chunks[g / 2];
        const uint32_t first = uint32_t(g % 2) * kSplatGroupSize, count = std::min(first + kSplatGroupSize, c.splatCount);
        const float share = keptShare(detail.perM2, groups[g].areaM2), growth = detailGrowth(share, groups[g].gain, groups[g].enough);
        float weight[kSplatGroupSize] = {};
        for (uint32_t rank = 0, drawn = drawnRanks(share); rank < drawn; ++rank) weight[placeOfRank(rank)] = detailWeight(share, rank);
        for (uint32_t i = first; i < count; ++i)
            if (weight[i - first] > 0) out.push_back({c.firstSplat + i, uint32_t(g / 2), weight[i - first], growth});
    }
}

}  // namespace dpl
