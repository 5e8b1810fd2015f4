// SPDX-License-Identifier: Apache-2.0
// What computes the steps of training.
#pragma once

#include <filesystem>
#include <functional>

#include "reconstruction/run/progress.h"
#include "reconstruction/run/reconstruct.h"
#include "reconstruction/training/trainer/training_engine.h"

namespace dpl {

/** The engine that is asked for, and a note which one it is. Null: the CPU, also where Kind::Auto finds no GPU. Errors: Kind::Gpu, and none
 *  that fits. */
Result<std::unique_ptr<TrainingEngine>> engineOf(const TrainingDevice& device, Progress& progress);

/** What a training leaves while it runs. */
struct TrainingFiles {
    std::filesystem::path checkpoint;
    std::filesystem::path engine;  // its name, where steps of the result are its own
};

/** Trains by train(engine). With Kind::Auto, an engine that fails (Code::Device, Code::OutOfMemory) is followed by train(nullptr), which
 *  goes on from the checkpoint where there is one. engine: null: the CPU trains. Errors: those of `train`, and of writing files.engine. */
Status trainOnDevice(const TrainingDevice& device, TrainingEngine* engine, const TrainingFiles& files, Progress& progress,
                     const std::function<Status(TrainingEngine*)>& train);

}  // namespace dpl
