// SPDX-License-Identifier: Apache-2.0
// The face of the selected avatar, by sliders.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Inside a panel that is open; nothing where the avatar has no expressions. */
void drawFace(ViewerState& state);

}  // namespace dpl
