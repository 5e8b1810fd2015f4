// SPDX-License-Identifier: Apache-2.0
// After packaging: a short optimisation of what the decoded file draws, and the pose of a frame that training never saw.
#pragma once

#include "reconstruction/splat/co_optimise.h"

namespace dpl {

/** Settings of a polish: colour (coefficient 0), opacity and size only; mesh, SH beyond it, poses, uv and φ stay as decoded; full
 * resolution; no density control. */
CoOptimiseSettings polishSettings(uint32_t steps, uint64_t seed, uint32_t shDegree);

/** Polishes avatar.splats on its own (decoded) mesh. frames carry the poses to use. The order of splats is kept. Cancelled when
 *  *cancel turns true (avatar is then unchanged). */
Result<CoOptimiseResult> polish(AvatarData& avatar, std::vector<TrainFrame> frames, uint32_t steps, uint64_t seed, Jobs& jobs,
                                const std::function<void(const CoOptimiseProgress&)>& progress = {},
                                const std::atomic<bool>* cancel = nullptr);

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

/** Test-time pose fit: everything frozen except frame.pose (docs/reference/registration.md). Keeps the best pose seen; never worse than the
 * start.
 */
Result<PoseFitResult> fitPose(const AvatarData& avatar, const TrainFrame& frame, const PoseFitSettings& settings, Jobs& jobs);

}  // namespace dpl
