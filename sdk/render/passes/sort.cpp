#include "sdk/render/passes/sort.h"

namespace dpl {

static_assert(gpu::kSortRounds % 2 == 0 && gpu::kGeneralSortRounds % 2 == 0 && gpu::kFloatSortRounds % 2 == 0, "an even number of rounds ends in the buffer it began in");
static_assert(gpu::kGeneralSortRounds * gpu::kSortDigitBits <= 24, "keys are made in float");

void addSort(FramePlan& plan, const FrameIds& ids) {
    BufferId from = ids.pairs, to = ids.pairsSwap;
    const uint64_t args = offsetof(gpu::FrameCounts, sortGroupsX);
    for (uint32_t round = 0; round < ids.sortRounds(); ++round) {
        const gpu::SortPush push{round * gpu::kSortDigitBits};
        plan.compute("sort.count", "sort.count").reads(ids.counts, from).writes(ids.histogram).push(push).groupsFrom(ids.counts, args);
        plan.compute("sort.scan", "compact.scan").reads(ids.counts).updates(ids.histogram).push(gpu::ScanPush{0, 0, 1}).groups(1);
        plan.compute("sort.scatter", "sort.scatter")
            .reads(ids.counts, from, ids.histogram)
            .writes(to)
            .push(push)
            .groupsFrom(ids.counts, args);
        std::swap(from, to);
    }
}

}  // namespace dpl
