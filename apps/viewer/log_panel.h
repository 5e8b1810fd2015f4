// SPDX-License-Identifier: Apache-2.0
// The window with all that the viewer and the library have said.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Draws it, if state.log. It closes itself by that. size: of the picture in ImGui's coordinates. */
void drawLog(ViewerState& state, float width, float height);

}  // namespace dpl
