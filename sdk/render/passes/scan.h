// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** How many things lie in the cells before each cell, row after row. The total ends up behind the sums that begin at push.firstSum. */
void addScan(FramePlan& plan, const std::string& label, BufferId counts, const TableIds& table, const gpu::RowScanPush& push,
             uint32_t rows);

/** Words of sums that so many rows need. */
constexpr uint64_t scanSumWords(uint64_t rows) {
    return rows * gpu::kRowScanGroup + 1;
}

}  // namespace dpl
