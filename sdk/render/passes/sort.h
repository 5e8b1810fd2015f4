// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Stable radix sort of the pairs by their key, nearest first. Keys have 16 bits, or 24 for general splats that reach far. A pair shrinks
 *  to one word when one digit of its key is left. The result is one word for each splat, its number, in ids.pairs. */
void addSort(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
