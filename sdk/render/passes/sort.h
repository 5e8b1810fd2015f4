// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Stable radix sort of the pairs by their 16-bit key (24-bit for general splats that reach far), near first; the splats in order are words
 * in ids.pairs. A pair shrinks to one word when a single digit is left of its key. */
void addSort(FramePlan& plan, const FrameIds& ids);

}  // namespace dpl
