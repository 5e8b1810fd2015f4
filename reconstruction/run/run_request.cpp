// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/run_request.h"

#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/stage_ingest.h"

namespace dpl {

Status StageOf<RunSettings>::inputs(StageInputs& in) {
    DPL_TRY([[maybe_unused]] const RunRequest* request, in.part<RunRequest>());
    DPL_TRY([[maybe_unused]] const FrameTable* table, in.part<FrameTable>());
    return {};
}

Result<RunSettings> StageOf<RunSettings>::compute(StageInputs& in) {
    DPL_TRY(const RunRequest* request, in.of<RunRequest>());
    DPL_TRY(const FrameTable* table, in.of<FrameTable>());
    return settingsOf(request->options, table->scan.labels);
}

}  // namespace dpl
