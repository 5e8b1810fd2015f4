// SPDX-License-Identifier: Apache-2.0
// Brings new runs into the viewer's state: dropped films, the coach, start, stop and continue.
#pragma once

#include "apps/viewer/state.h"

namespace dpl {

/** Offers to make an avatar of a film: of a folder, or of videos, which join those that are being chosen. Absolute paths, at least one.
 *  InvalidArgument: another one is being begun. */
Status offerRun(ViewerState& state, const std::vector<std::filesystem::path>& film);

/** Follows the wishes for runs and the coach; wishes for a run that has begun to be opened. Call once a frame. Errors: a sentence for the
 *  user. */
Status fulfilRuns(ViewerState& state);

}  // namespace dpl
