// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/profile_steps.h"

namespace dpl {

CoOptimiseSettings slowestSteps(CoOptimiseSettings training) {
    training.fullResolutionOnly = true;
    training.init.splatCount = std::max(training.init.splatCount, training.maxSplats);
    return training;
}

Result<ProfiledTraining> profileSteps(CoOptimiseInput input, CoOptimiseSettings settings, const ProfiledSteps& steps, Jobs& jobs,
                                      TrainingEngine* engine) {
    if (steps.splats > 0) settings.init.splatCount = settings.maxSplats = steps.splats;
    settings = slowestSteps(settings);
    settings.steps = std::max(settings.steps, 20 * (steps.warmUp + steps.steps));  // density control waits until 8 % of them
    ProfiledTraining out;
    out.vertices = uint32_t(input.mesh.restPositions.size()), out.triangles = uint32_t(input.mesh.triangles.size());
    out.nodes = input.correctives.nodeCount, out.frames = uint32_t(input.frames.size());
    DPL_TRY(auto trainer, CoOptimiser::create(std::move(input), settings, jobs, engine));
    DPL_RETURN_IF_ERROR(trainer->run(steps.warmUp));
    trainer->startProfile();
    if (engine) engine->takeCrossedBytes();
    DPL_RETURN_IF_ERROR(trainer->run(steps.steps));
    out.profile = trainer->profile();
    if (engine) out.passes = engine->passTimes(), out.crossedBytes = double(engine->takeCrossedBytes()) / steps.steps;
    out.loss = trainer->recentLoss();
    out.splats = trainer->splatCount();
    out.shFloats = shCoefficientCount(settings.init.shDegree) * 3, out.rowFloats = TrainableSplats::strideFor(settings.init.shDegree);
    return out;
}

}  // namespace dpl
