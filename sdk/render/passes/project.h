// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Writes footprint, colour and visibility of every splat in every view. For general splats it also widens the extent along the sort axis
 *  in `counts`, which must be 0 before. */
void addProject(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject);

}  // namespace dpl
