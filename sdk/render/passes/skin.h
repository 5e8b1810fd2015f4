// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Poses the rest vertices by the palette and writes them with their brightness. Widens the extent along the sort axis in `counts`, which
 *  must be 0 before. */
void addSkin(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject);

}  // namespace dpl
