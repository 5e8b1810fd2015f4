// SPDX-License-Identifier: Apache-2.0
// Two optimisations after training: a short polish of the decoded avatar, and the pose fit of a held-out frame.
#pragma once

#include "reconstruction/training/trainer/co_optimise.h"
#include "reconstruction/training/trainer/priors.h"

namespace dpl {

/** Settings of a polish. It learns colour (SH coefficient 0), opacity and size of the splats at full resolution. The mesh, the other SH
 *  coefficients, poses, uv and φ do not change, and no splat is added or removed. */
CoOptimiseSettings polishSettings(uint32_t steps, uint64_t seed, uint32_t shDegree);

/** Polishes the splats of a decoded avatar on its own mesh. triangleLabel: as in CoOptimiseInput. The poses are those of `frames`. Keeps
 * the order of the splats. Errors: Cancelled. */
Result<AvatarData> polish(AvatarData avatar, std::vector<uint8_t> triangleLabel, std::vector<TrainFrame> frames, uint32_t steps,
                          uint64_t seed, Jobs& jobs);

struct PoseFitSettings {
    uint32_t iterations = 80;
    uint64_t seed = 1;
    double rateRotation = 6e-3, rateTranslation = 4e-3, end = 0.05;
    double pictureTrust = priors::kFittedPictureTrust, depthTrust = priors::kFittedDepthTrust;  // depthTrust: along the view
    LossWeights loss{0.8f, 0.2f, 1.0f, 0.0f};
};

struct PoseFitResult {
    Pose pose;
    double lossBefore = 0, lossAfter = 0;  // total loss on one fixed background
};

/** Test-time pose fit (docs/reference/registration.md): optimises frame.pose and nothing else, with a pull towards it by
 *  frame.precision. Returns the likeliest pose that it met, which may be the given one. */
Result<PoseFitResult> fitPose(const AvatarData& avatar, const TrainFrame& frame, const PoseFitSettings& settings, Jobs& jobs);

}  // namespace dpl
