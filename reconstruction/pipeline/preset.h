// SPDX-License-Identifier: Apache-2.0
// What draft, standard and high mean, as numbers.
#pragma once

#include "reconstruction/pipeline/reconstruct.h"
#include "reconstruction/splat/co_optimise.h"
#include "reconstruction/splat/polish.h"

namespace dpl {

/** The numbers that a run is made with. Stages and their keys see these and never the name of a preset. */
struct RunSettings {
    CoOptimiseSettings training;
    double timeBudgetMinutes = 0;  // above 0 a probe chooses training.steps
    uint32_t polishSteps = 0;      // colour, opacity and size on the decoded bytes
    PoseFitSettings poseFit;       // of held-out frames
};

RunSettings settingsOf(const ReconstructOptions& options);

}  // namespace dpl
