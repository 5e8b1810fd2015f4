// SPDX-License-Identifier: Apache-2.0
// A short training that follows a finished one, for avatars from which a part was taken: what remains makes up for the part as well as it
// can.
#pragma once

#include <functional>

#include "reconstruction/training/trainer/co_optimise.h"

namespace dpl {

/** What the avatar may learn besides splats, surface and poses. A part that was taken away must not be learned again. */
struct RetrainParts {
    bool correctiveOffsets = true, correctiveLight = true;
};

/** Settings of `steps` steps at the rates at which a training with settings `trained` ended. */
CoOptimiseSettings retrainSettings(const CoOptimiseSettings& trained, const RetrainParts& parts, uint32_t steps, uint32_t shDegree);

/** Trains an avatar on. triangleLabel: as in CoOptimiseInput. The poses of `frames` are those that it was trained with. Splats keep their
 * number. The result does not depend on the number of threads. run: takes the trainer to its end, as CoOptimiser::run() does. Errors: those
 * of `run`; Cancelled. */
Result<AvatarData> retrain(
    AvatarData avatar, std::vector<uint8_t> triangleLabel, std::vector<TrainFrame> frames, const CoOptimiseSettings& settings, Jobs& jobs,
    const std::function<Status(CoOptimiser&)>& run = [](CoOptimiser& trainer) { return trainer.run(); });

}  // namespace dpl
