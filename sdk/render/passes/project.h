// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Footprint, colour and visibility of every splat in every view. For general splats also their extent along the sort axis, which must be 0
 * before. */
void addProject(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
