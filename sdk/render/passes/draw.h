#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** What draws a frame of this shape with so many samples a pixel. */
DrawPipelineDesc drawPipelineOf(const FrameIds& ids, uint32_t samples);

/** One indirect draw of all survivors into every view; after tiles, which tell it through the counts, it only does and clears anything where they have left the frame to it. */
void addDraw(FramePlan& plan, const FrameIds& ids, bool tiles);

}  // namespace dpl
