// SPDX-License-Identifier: Apache-2.0
// The panel of a watched run.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** What the run does, how long it still takes, and how well it fits its pictures. Inside a panel that is open.
 *  pictureBeside: the held-back picture has room in the window. */
void drawRun(ViewerState& state, bool pictureBeside);

}  // namespace dpl
