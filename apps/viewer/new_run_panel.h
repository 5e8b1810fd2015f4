// SPDX-License-Identifier: Apache-2.0
// The panel that makes an avatar of a dropped film.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Choices, and what the coach says, of state.starter. Inside a panel that is open. */
void drawNewRun(ViewerState& state);

/** Stop and continue for the run that is watched, and what the coach said of its film. Inside a panel that is open. */
void drawRunControls(ViewerState& state);

}  // namespace dpl
