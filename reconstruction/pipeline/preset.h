// SPDX-License-Identifier: Apache-2.0
// The numbers behind the presets draft, standard and high.
#pragma once

#include "reconstruction/pipeline/reconstruct.h"
#include "reconstruction/splat/co_optimise.h"
#include "reconstruction/splat/polish.h"

namespace dpl {

/** The settings of a run. Stages and their keys depend on these numbers, and never on the name of a preset. */
struct RunSettings {
    CoOptimiseSettings training;
    double timeBudgetMinutes = 0;  // above 0: a timed probe chooses training.steps
    double checkpointS = 30;       // between checkpoints of training; no result depends on it
    uint32_t polishSteps = 0;      // of colour, opacity and size, on the decoded avatar
    PoseFitSettings poseFit;       // of held-out frames
    bool layers = true;            // false: one layer, whatever the labels say
};

RunSettings settingsOf(const ReconstructOptions& options);

/** The settings of the stages that follow a training of `steps` steps. They train on for shares of these steps, so that a run with few
 *  steps, or with a time budget, does not spend most of its time after training. */
RunSettings settingsAfterTraining(RunSettings settings, uint32_t steps);

}  // namespace dpl
