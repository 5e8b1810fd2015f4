// SPDX-License-Identifier: Apache-2.0
// What is loaded, and what the selected one does.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Inside a panel that is open. */
void drawSubjects(ViewerState& state);

}  // namespace dpl
