// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/retrain.h"

namespace dpl {

CoOptimiseSettings retrainSettings(const CoOptimiseSettings& trained, const RetrainParts& parts, uint32_t steps, uint32_t shDegree) {
    CoOptimiseSettings s = trained;
    s.steps = steps, s.init.shDegree = shDegree;
    s.densify = false, s.fullResolutionOnly = true;
    const auto goOn = [](float& rate, float end) { rate *= end; };
    goOn(s.rateUv, s.endUv), goOn(s.ratePhi, s.endLogScale), goOn(s.rateLogScale, s.endLogScale), goOn(s.rateOpacity, s.endOpacity);
    goOn(s.rateDc, s.endColour), goOn(s.rateRest, s.endColour), goOn(s.rateOffsets, s.endOffsets);
    goOn(s.rateRotation, s.endPose), goOn(s.rateTranslation, s.endPose);
    goOn(s.rateNodeOffset, parts.correctiveOffsets ? s.endNodes : 0), goOn(s.rateNodeLight, parts.correctiveLight ? s.endNodes : 0);
    s.nodeDecay *= s.endNodes;
    s.endUv = s.endLogScale = s.endOpacity = s.endColour = s.endOffsets = s.endPose = s.endNodes = 1;
    return s;
}

Result<AvatarData> retrain(AvatarData avatar, std::vector<uint8_t> triangleLabel, std::vector<TrainFrame> frames,
                           const CoOptimiseSettings& settings, Jobs& jobs, const std::function<Status(CoOptimiser&)>& run) {
    DPL_TRY(auto trainer,
            CoOptimiser::createFrom(inputOf(avatar, std::move(triangleLabel), std::move(frames)), avatar.splats, settings, jobs));
    DPL_RETURN_IF_ERROR(run(*trainer));
    CoOptimiseResult result = trainer->result();
    avatar.splats = std::move(result.splats);
    avatar.mesh.restPositions = std::move(result.restPositions);
    avatar.correctives = std::move(result.correctives);
    return avatar;
}

}  // namespace dpl
