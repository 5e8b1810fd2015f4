// SPDX-License-Identifier: Apache-2.0
// The list of keys.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** What keys and mouse do, if state.help. It closes itself by that. size: of the picture in ImGui's coordinates. */
void drawHelp(ViewerState& state, float width, float height);

}  // namespace dpl
