// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Turns posed vertices into one frame for each triangle. */
void addTriangles(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject);

}  // namespace dpl
