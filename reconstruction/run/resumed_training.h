// SPDX-License-Identifier: Apache-2.0
// A training that a kill or a stop interrupts, and that the next run continues.
#pragma once

#include <filesystem>
#include <functional>

#include "reconstruction/run/progress.h"
#include "reconstruction/training/trainer/co_optimise.h"

namespace dpl {

/** Trains to the end. Goes on from the file `checkpoint` where it belongs to this training, else a note says why not. Leaves one there
 * every everyS seconds and at a stop; the caller removes it once the result is kept. after: called every 100 steps; may be empty. Errors:
 * Cancelled; a checkpoint that cannot be written. */
Status trainFromCheckpoint(CoOptimiser& trainer, const std::filesystem::path& checkpoint, double everyS, Progress& progress,
                           const std::function<void()>& after = {});

}  // namespace dpl
