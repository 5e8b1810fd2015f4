// SPDX-License-Identifier: Apache-2.0
// The validation split: training frames that train nothing, on which a reconstruction decides (docs/reference/metrics.md).
#pragma once

#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** Turns a few frames of Split::Train into Split::Validation: of moving frames, in order of time, one run in a row and others alone; of
 *  still full-body frames and of close-ups the same in the scan's order. A still frame stays that too few others of its kind see from its
 *  side. A kind with too few usable training frames gives none. Depends on kinds, times, cameras and `usable` (one a frame), not on
 *  pictures or a seed. Returns what was set aside, or why nothing was, as a sentence. */
std::string setValidationAside(Scan& scan, const std::vector<bool>& usable);

}  // namespace dpl
