// SPDX-License-Identifier: Apache-2.0
// `doppel bench training`: what a step of the training costs, part by part.
#pragma once

#include "reconstruction/run/profile_training.h"

namespace dpl {

struct TrainingBenchOptions {
    ReconstructOptions reconstruct;  // scan, out, device, seed and threads are used; without a scan the procedural subject is trained on
    ProfiledSteps steps;
    std::string size = "378x504";  // of the procedural subject's pictures
    std::filesystem::path jsonFile;
};

/** Measures steps, prints a table with a row for each part, and writes the same figures as JSON lines. */
Status runTrainingBench(const TrainingBenchOptions& options);

}  // namespace dpl
