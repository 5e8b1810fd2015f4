// SPDX-License-Identifier: Apache-2.0
// What the viewer tells just now.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Shown while the panels are hidden too. size: of the picture in ImGui's coordinates. */
void drawMessages(ViewerState& state, float width, float height);

}  // namespace dpl
