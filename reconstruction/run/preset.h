// SPDX-License-Identifier: Apache-2.0
// The settings of a run, from its preset and options.
#pragma once

#include <span>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/run/reconstruct.h"
#include "reconstruction/training/trainer/co_optimise.h"
#include "reconstruction/training/trainer/polish.h"

namespace dpl {

/** The settings of a run. Stages and their keys depend on these numbers, and never on the name of a preset. */
struct RunSettings {
    CoOptimiseSettings training;
    double timeBudgetMinutes = 0;  // of the whole run; above 0: a timed probe chooses training.steps
    double checkpointS = 30;       // between checkpoints of training; no result depends on it
    TrainingDevice device;         // of training
    std::filesystem::path from;    // a checkpoint of another run, from which training goes on; empty: it starts
    uint32_t polishSteps = 0;      // of colour, opacity and size, on the decoded avatar
    PoseFitSettings poseFit;       // of held-out frames
    bool layers = true;            // false: one layer, whatever the labels say
};

/** labels: the scan's. Without any, the values are those of our networks. */
RunSettings settingsOf(const ReconstructOptions& options, std::span<const ScanLabel> labels = {});

/** The same settings with `steps` steps of training. Stages after it train on for shares of these steps, and the polish is cut to a tenth
 *  of them, so that a short training is not followed by a long rest of the run. */
RunSettings withTrainingSteps(RunSettings settings, uint32_t steps);

}  // namespace dpl
