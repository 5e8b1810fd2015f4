// SPDX-License-Identifier: Apache-2.0
// The panel of a comparison with the photographs of a scan.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Frame, way and slider of state.compared. Inside a panel that is open. */
void drawComparison(ViewerState& state);

}  // namespace dpl
