// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/sort.h"

#include "sdk/render/passes/scan.h"

namespace dpl {

static_assert(gpu::kWideSortRounds * gpu::kSortDigitBits <= 24, "keys are made in float");
static_assert(gpu::kSortDigits == 1u << gpu::kSortDigitBits && gpu::kSortIndexBits + gpu::kSortDigitBits == 32 && gpu::kSortRounds >= 2);

void addSort(FramePlan& plan, const FrameIds& ids) {
    BufferId from = ids.unsorted(), to = from == ids.pairs ? ids.pairsSwap : ids.pairs;
    const uint64_t args = offsetof(gpu::FrameCounts, runGroupsX);
    for (uint32_t round = 0; round < ids.sortRounds(); ++round) {
        const gpu::SortPush push{round * gpu::kSortDigitBits};
        const uint32_t left = ids.sortRounds() - 1 - round;
        plan.compute("sort.count", left == 0 ? "sort.count.packed" : "sort.count")
            .reads(ids.counts, from)
            .writes(ids.digits.cells)
            .push(push)
            .groupsFrom(ids.counts, args);
        addScan(plan, "sort.scan", ids.counts, ids.digits, {}, gpu::kSortDigits);
        plan.compute("sort.scatter", left == 0   ? "sort.scatter.packed"
                                     : left == 1 ? "sort.scatter.pack"
                                                 : "sort.scatter")
            .reads(ids.counts, from, ids.digits.places)
            .writes(to)
            .push(push)
            .groupsFrom(ids.counts, args);
        std::swap(from, to);
    }
}

}  // namespace dpl
