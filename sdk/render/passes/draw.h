#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** What draws a frame of this shape with so many samples a pixel. */
DrawPipelineDesc drawPipelineOf(const FrameIds& ids, uint32_t samples);

/** One indirect draw of all survivors into every view; after the tiles only if these have left the frame to it. */
void addDraw(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
