// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Exclusive prefix sum over the cells of a table, row after row. Writes the total behind the sums that begin at push.firstSum. */
void addScan(FramePlan& plan, const std::string& label, BufferId counts, const TableIds& table, const gpu::RowScanPush& push,
             uint32_t rows);

/** Size in words of the sums of a table with this many rows. */
constexpr uint64_t scanSumWords(uint64_t rows) {
    return rows * gpu::kRowScanGroup + 1;
}

}  // namespace dpl
