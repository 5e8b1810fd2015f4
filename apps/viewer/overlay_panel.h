// SPDX-License-Identifier: Apache-2.0
// Chooses and draws what is weak in the selected avatar's pose.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Which overlay, and its words. Inside a panel that is open. */
void drawOverlayChoice(ViewerState& state);

/** The shapes of state.weak over the picture and below all panels. camera: of the picture, pixels; scale: pixels for one of ImGui's
 *  coordinates. */
void drawOverlay(const ViewerState& state, const Camerad& camera, float scale);

}  // namespace dpl
