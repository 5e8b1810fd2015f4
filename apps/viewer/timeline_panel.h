// SPDX-License-Identifier: Apache-2.0
// The bar below: play, time, loop and speed.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Of all clips; its length is that of state.player(). Nothing where no clip plays. size: of the picture in ImGui's coordinates. */
void drawTimeline(ViewerState& state, float width, float height);

}  // namespace dpl
