// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Palette and rest vertices to posed vertices with their brightness, and their extent along the sort axis. The extent must be 0 before. */
void addSkin(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
