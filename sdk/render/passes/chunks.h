// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Finds the groups of splats that projection and colour have to read. */
void addChunks(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject);

}  // namespace dpl
