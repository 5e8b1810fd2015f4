// SPDX-License-Identifier: Apache-2.0
// Opens the engine that trains on a GPU: by Vulkan, or in a build without it by Metal. Builds without both have this header too, and no
// engine.
#pragma once

#include <memory>
#include <string>

#include "reconstruction/training/trainer/training_engine.h"

namespace dpl {

struct EngineRequest {
    std::string name;            // part of the device's name; empty: the best one
    bool allowEmulated = false;  // also GPUs that the CPU plays; they are slower than training on the CPU
};

/** An engine whose device has computed the gradients of a small picture as the CPU does. Unsupported: no device that fits, or one that
 *  computes wrong. */
Result<std::unique_ptr<TrainingEngine>> openTrainingEngine(const EngineRequest& request);

}  // namespace dpl
