// SPDX-License-Identifier: Apache-2.0
// The order of the passes in one frame.
#pragma once

#include <span>

#include "sdk/render/frame_ids.h"
#include "sdk/render/passes/tiles.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Appends all steps of a frame that draws `subjects`, and the copy of its counts into `finalCounts`. Creates nothing and submits nothing:
 *  the caller owns buffers, target and plan. tiles: of a frame with splats, which fills frame.tilePixels; null: quads fill frame.target. */
void planFrame(FramePlan& plan, const FrameIds& frame, std::span<const SubjectIds> subjects, const TilePlan* tiles, BufferId finalCounts);

}  // namespace dpl
