// SPDX-License-Identifier: Apache-2.0
// The panels of the viewer, in Dear ImGui.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Shows and changes the state. size: of the picture in ImGui's coordinates. */
void drawPanels(ViewerState& state, float width, float height);

/** What the panels leave free, in ImGui's coordinates: from left to right. The avatars are centred there. */
struct FreeSpan {
    float left = 0, right = 0;
};
FreeSpan freeSpan(const ViewerState& state, float width);

/** What a held-back picture of a watched run has of that, to the left of the avatars. Empty: there is none, or no room for both. */
FreeSpan heldBackSpan(const ViewerState& state, float width);
constexpr float kHeldBackMargin = 24;

}  // namespace dpl
