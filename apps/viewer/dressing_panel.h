// SPDX-License-Identifier: Apache-2.0
// Dresses the selected avatar.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Whose garments it puts on. Inside a panel that is open; nothing where no other avatar is there. */
void drawDressing(ViewerState& state);

}  // namespace dpl
