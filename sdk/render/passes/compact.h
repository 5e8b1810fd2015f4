// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Stable compaction: (depth key, splat) of the seen splats in splat order, and the indirect arguments of what follows. */
void addCompact(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
