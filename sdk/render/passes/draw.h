#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** One indirect draw of all survivors into every view, then the copy to memory. */
void addDraw(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
