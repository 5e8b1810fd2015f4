// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Adds the pass for one subject; the first subject also clears the buffer. It turns posed vertices into the nearest depth of the
 *  mesh at each pixel of each view, as float bits, infinite where there is none. It needs only the posed vertices, so it may run any
 *  time after them. */
void addMeshDepth(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject);

}  // namespace dpl
