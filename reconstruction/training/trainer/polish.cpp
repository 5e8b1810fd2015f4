// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/polish.h"

#include "reconstruction/training/trainer/pose_fitter.h"

namespace dpl {

CoOptimiseSettings polishSettings(uint32_t steps, uint64_t seed, uint32_t shDegree) {
    CoOptimiseSettings s;
    s.seed = seed, s.steps = steps, s.init.shDegree = shDegree;
    s.learnGeometry = s.learnPoses = s.learnCorrectives = s.densify = s.learnPlacement = false;
    s.fullResolutionOnly = true;
    s.loss.cloth = 0;
    // The splats are nearly right, so steps are small and fall to a tenth.
    s.rateLogScale = 1e-3f, s.rateOpacity = 1e-2f, s.rateDc = 2e-3f;
    s.rateRest = 0;  // splats share the palette entries of SH coefficients above 0
    s.endLogScale = s.endOpacity = s.endColour = 0.1f;
    return s;
}

Result<AvatarData> polish(AvatarData avatar, std::vector<uint8_t> triangleLabel, std::vector<TrainFrame> frames, uint32_t steps,
                          uint64_t seed, Jobs& jobs) {
    DPL_TRY(auto trainer, CoOptimiser::createFrom(inputOf(avatar, std::move(triangleLabel), std::move(frames)), avatar.splats,
                                                  polishSettings(steps, seed, avatar.splats.shDegree), jobs));
    DPL_RETURN_IF_ERROR(trainer->run());
    avatar.splats = trainer->result().splats;
    return avatar;
}

Result<PoseFitResult> fitPose(const AvatarData& avatar, const TrainFrame& frame, const PoseFitSettings& settings, Jobs& jobs) {
    return PoseFitter(avatar, jobs).fit(frame, settings, jobs);
}

}  // namespace dpl
