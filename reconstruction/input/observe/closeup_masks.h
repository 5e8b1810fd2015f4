// SPDX-License-Identifier: Apache-2.0
// Holds masks of close-ups against the visual hull: a network knows whole people, and often fails at a hand or a shoe.
#pragma once

#include <functional>

#include "reconstruction/input/capture/scan.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** What the visual hull of the full-body pictures' silhouettes says of a close-up's mask. */
struct CloseupMask {
    size_t frame = 0;           // of Scan::frames
    double agreement = 0;       // IoU of the mask and the hull; 0 without a mask
    double certainty = 0;       // IoU of the hull of fewer views' consent and that of more, in this picture
    bool contradicted = false;  // the hull does not support the mask: both differ by more than the hull is uncertain, or it says little
    ImageGrey8 mask;            // of a contradicted close-up: the hull, its edge refined, in pixels of the frame's files; empty
                                // when the hull is too uncertain here (a hand, which sways)
};

/** Checks the mask of each close-up for which isFound(frame) holds (docs/reference/observations.md). Returns nothing when fewer than eight
 * still training masks show the person, or their hull is empty. Errors name a file that cannot be read. Needs cameras. */
Result<std::vector<CloseupMask>> checkCloseupMasks(const Scan& scan, const std::function<bool(const ScanFrame&)>& isFound, Jobs& jobs);

}  // namespace dpl
