// SPDX-License-Identifier: Apache-2.0
// What the last frames drew and took.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Inside a panel that is open. */
void drawTimings(const ViewerState& state);

}  // namespace dpl
