// SPDX-License-Identifier: Apache-2.0
// What computes the steps of training.
#pragma once

#include "reconstruction/run/progress.h"
#include "reconstruction/run/reconstruct.h"
#include "reconstruction/training/trainer/training_engine.h"

namespace dpl {

/** The engine that is asked for, and a note which one it is. Null: the CPU, also where Kind::Auto finds no GPU. Errors: Kind::Gpu, and none
 *  that fits. */
Result<std::unique_ptr<TrainingEngine>> engineOf(const TrainingDevice& device, Progress& progress);

}  // namespace dpl
