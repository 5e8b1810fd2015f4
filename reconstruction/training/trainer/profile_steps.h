// SPDX-License-Identifier: Apache-2.0
// Measures training steps (`doppel bench training`).
#pragma once

#include "reconstruction/training/trainer/co_optimise.h"

namespace dpl {

struct ProfiledSteps {
    uint32_t warmUp = 60;  // steps that are not measured
    uint32_t steps = 60;
    uint32_t splats = 0;  // 0: as many as the settings allow
};

/** The means of a step. */
struct ProfiledTraining {
    StepProfile profile;
    std::vector<PassTime> passes;  // of the engine's last step
    double crossedBytes = 0;       // between host and engine
    double loss = 0;               // at the end: whoever compares two programs sees that both computed the same
    uint32_t splats = 0, rowFloats = 0, shFloats = 0, vertices = 0, triangles = 0, nodes = 0, frames = 0;
};

/** The same training with every step as slow as its last ones: pictures at full size, and as many splats as density control allows. */
CoOptimiseSettings slowestSteps(CoOptimiseSettings training);

/** Runs slowestSteps(settings) from the start, and measures them after the warm-up. Errors: those of the trainer. Cancelled. */
Result<ProfiledTraining> profileSteps(CoOptimiseInput input, CoOptimiseSettings settings, const ProfiledSteps& steps, Jobs& jobs,
                                      TrainingEngine* engine = nullptr);

}  // namespace dpl
