// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/scan.h"

namespace dpl {

void addScan(FramePlan& plan, const std::string& label, BufferId counts, const TableIds& table, const gpu::RowScanPush& push,
             uint32_t rows) {
    plan.compute(label, "scan.totals").reads(counts, table.cells).writes(table.sums).push(push).groups(rows);
    plan.compute(label, "scan.sums").updates(table.sums).push(gpu::ScanPush{push.firstSum, rows * gpu::kRowScanGroup}).groups(1);
    plan.compute(label, "scan.places").reads(counts, table.cells, table.sums).writes(table.places).push(push).groups(rows);
}

}  // namespace dpl
