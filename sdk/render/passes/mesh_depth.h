// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Of one subject; the first clears the buffer. Posed vertices to the nearest depth of the mesh at each pixel of each view, as float bits,
 * infinite where there is none. Wants the posed vertices alone: it may run any time after them. */
void addMeshDepth(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
