// SPDX-License-Identifier: Apache-2.0
// How the picture looks: room, lens, limits.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Inside a panel that is open. */
void drawPictureChoices(ViewerState& state);

}  // namespace dpl
