// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Pipeline that draws a frame of this shape at this number of samples. */
DrawPipelineDesc drawPipelineOf(const FrameIds& ids, uint32_t samples);

/** One indirect draw of all survivors into every view. */
void addDraw(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
