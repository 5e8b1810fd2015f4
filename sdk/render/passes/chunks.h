// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** The chunks of splats that projection and colour have to look at. */
void addChunks(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
