// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** What a write of a subject's splats uses besides the subject. */
struct WriteIds {
    BufferId data;          // WriteData; the CPU writes it before each run
    BufferId kept;          // KeptRecords; any other buffer where all splats are written
    BufferId rows;          // Lent: the app's
    uint32_t keptRows = 0;  // 0: all splats are written
};

/** Writes the splats of a subject, whose triangles are posed, into an app's buffer. */
void addWrite(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject, const WriteIds& write);

}  // namespace dpl
