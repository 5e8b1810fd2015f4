// SPDX-License-Identifier: Apache-2.0
// The window that chooses a file to open.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Shows what was opened lately and what state.open lists, and wishes for what is clicked. */
void drawOpen(ViewerState& state, float width, float height);

/** Some of what was opened lately, as buttons. Inside a panel that is open. */
void drawRecent(ViewerState& state, size_t most);

}  // namespace dpl
