// SPDX-License-Identifier: Apache-2.0
// After training: a short optimisation on the decoded bytes, and the pose of a frame that training never saw.
#pragma once

#include "reconstruction/splat/co_optimise.h"

namespace dpl {

/** A polish learns colour (SH coefficient 0), opacity and size, at full resolution. Mesh, further SH, poses, uv and φ stay as decoded, and
 *  no splat is added or removed. */
CoOptimiseSettings polishSettings(uint32_t steps, uint64_t seed, uint32_t shDegree);

/** `avatar` with its splats polished on its own (decoded) mesh. frames carry the poses to use. The order of splats is kept. Cancelled when
 *  *cancel turns true. */
Result<AvatarData> polish(AvatarData avatar, std::vector<TrainFrame> frames, uint32_t steps, uint64_t seed, Jobs& jobs,
                          const std::function<void(const CoOptimiseProgress&)>& progress = {}, const std::atomic<bool>* cancel = nullptr);

struct PoseFitSettings {
    uint32_t iterations = 80;
    uint64_t seed = 1;
    double rateRotation = 6e-3, rateTranslation = 4e-3, end = 0.05;
    LossWeights loss{0.8f, 0.2f, 1.0f, 0.0f};
    float posePull = 1e-2f;  // ‖log(R R0ᵀ)‖² towards the given pose
};

struct PoseFitResult {
    Pose pose;
    double lossBefore = 0, lossAfter = 0;  // total loss on one fixed background
};

/** Test-time pose fit (docs/reference/registration.md): everything is frozen except frame.pose. Returns the best pose seen, which is never
 *  worse than the start. */
Result<PoseFitResult> fitPose(const AvatarData& avatar, const TrainFrame& frame, const PoseFitSettings& settings, Jobs& jobs);

}  // namespace dpl
