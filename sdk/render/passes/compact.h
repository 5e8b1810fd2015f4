// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Stable compaction: writes (depth key, splat) of the visible splats in splat order, and the indirect arguments of the later passes. */
void addCompact(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
