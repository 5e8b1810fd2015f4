// SPDX-License-Identifier: Apache-2.0
// Where training starts the column "has moved" of the motion modes: at what the outlines of the moving pictures ask of the garments.
// Gradients see a stripe's width and do not find a hem two centimetres away. docs/reference/correctives.md, "Motion modes".
//
//   moving frames that have moved ─► silhouette fit of the clothed mesh in their poses ─► offsets of garments ─► means of the nodes
#pragma once

#include "reconstruction/training/trainer/co_optimise.h"

namespace dpl {

/** What the silhouette fit of the moving frames found. */
struct MovedStart {
    size_t views = 0;                    // 0: the column starts at zero
    double iouBefore = 0, iouAfter = 0;  // mean over the views
};

/** Sets the nodes' values in that column. Leaves them at zero without motion modes, without a garment layer, and with fewer than 12 frames
 *  that have moved. Same result on any number of threads. Errors: those of the pictures and of fitSurface(). */
Result<MovedStart> startMovedColumn(CoOptimiseInput& input, Jobs& jobs);

}  // namespace dpl
