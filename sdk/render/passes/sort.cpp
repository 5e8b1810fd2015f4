#include "sdk/render/passes/sort.h"

namespace dpl {

static_assert(gpu::kWideSortRounds * gpu::kSortDigitBits <= 24, "keys are made in float");
static_assert(gpu::kSortTable == gpu::kSortDigits + 1 && gpu::kSortDigits == 1u << gpu::kSortDigitBits);

void addSort(FramePlan& plan, const FrameIds& ids) {
    BufferId from = ids.unsorted(), to = from == ids.pairs ? ids.pairsSwap : ids.pairs;
    const uint64_t args = offsetof(gpu::FrameCounts, runGroupsX);
    for (uint32_t round = 0; round < ids.sortRounds(); ++round) {
        const gpu::SortPush push{round * gpu::kSortDigitBits};
        plan.compute("sort.count", "sort.count").reads(ids.counts, from).updates(ids.histogram).push(push).groupsFrom(ids.counts, args);
        plan.compute("sort.scan", "scan.rows").reads(ids.counts).updates(ids.histogram).push(gpu::RowScanPush{0, gpu::kSortTable, 0}).groups(gpu::kSortDigits);
        plan.compute("sort.scan", "scan.sums").updates(ids.histogram).push(gpu::ScanPush{0, gpu::kSortDigits}).groups(1);
        plan.compute("sort.scatter", "sort.scatter").reads(ids.counts, from).updates(ids.histogram).writes(to).push(push).groupsFrom(ids.counts, args);
        std::swap(from, to);
    }
}

}  // namespace dpl
