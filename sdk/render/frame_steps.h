// SPDX-License-Identifier: Apache-2.0
// The order of the passes in one frame.
#pragma once

#include <span>

#include "sdk/render/frame_ids.h"
#include "sdk/render/passes/tiles.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Appends all steps of a frame that draws `subjects` into frame.target, and the copy of its counts into `finalCounts`. Creates nothing
 *  and submits nothing: the caller owns buffers, target and plan. tiles: null when only quads fill. */
void planFrame(FramePlan& plan, const FrameIds& frame, std::span<const SubjectIds> subjects, const TilePlan* tiles, BufferId finalCounts);

}  // namespace dpl
