// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/splat/polish.h"

#include <cmath>

#include "reconstruction/splat/random.h"
#include "reconstruction/splat/rotation_vector.h"

namespace dpl {

CoOptimiseSettings polishSettings(uint32_t steps, uint64_t seed, uint32_t shDegree) {
    CoOptimiseSettings s;
    s.seed = seed, s.steps = steps, s.init.shDegree = shDegree;
    s.learnGeometry = s.learnPoses = s.learnCameras = s.learnCorrectives = s.densify = s.learnPlacement = false;
    s.fullResolutionOnly = true;
    s.loss.cloth = 0;
    // The splats are nearly right, so steps are small and fall to a tenth.
    s.rateLogScale = 1e-3f, s.rateOpacity = 1e-2f, s.rateDc = 2e-3f;
    s.rateRest = 0;  // splats share the palette entries of SH coefficients above 0
    s.endLogScale = s.endOpacity = s.endColour = 0.1f;
    return s;
}

Result<AvatarData> polish(AvatarData avatar, std::vector<TrainFrame> frames, uint32_t steps, uint64_t seed, Jobs& jobs,
                          const std::function<void(const CoOptimiseProgress&)>& progress, const std::atomic<bool>* cancel) {
    CoOptimiseInput input;
    input.joints = avatar.joints, input.mesh = avatar.mesh, input.correctives = avatar.correctives, input.frames = std::move(frames);
    DPL_TRY(auto trainer,
            CoOptimiser::createFrom(std::move(input), avatar.splats, polishSettings(steps, seed, avatar.splats.shDegree), jobs));
    DPL_CHECK_OK(trainer->run(progress, cancel));
    avatar.splats = trainer->result().splats;
    return avatar;
}

Result<PoseFitResult> fitPose(const AvatarData& avatar, const TrainFrame& frame, const PoseFitSettings& settings, Jobs& jobs) {
    DPL_CHECK_OK(checkTrainFrame(frame));
    DPL_CHECK_OK(checkPose(avatar.joints, frame.pose));
    LevelFrame coarse = makeLevelFrame(frame, std::max(0.5f, coarsestScale(frame)), {}, false), fine = makeLevelFrame(frame, 1, {}, true);
    coarse.kappaPx2 = fine.kappaPx2 = avatar.kappaPx2;
    if (!fine.used) return fail(Code::InvalidArgument, "frame '{}': nobody is in its mask, so its pose cannot be fitted", frame.name);
    const std::vector<float> floors(avatar.mesh.triangles.size(), 0.0f);
    TrainableSplats splats = TrainableSplats::fromSplatData(avatar.splats, floors);
    splats.activateAll(jobs);
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    const VertexIncidence incidence(avatar.mesh.triangles, avatar.mesh.restPositions.size());
    const PassSubject subject{splats, avatar.mesh, avatar.correctives, avatar.joints, bind, incidence};
    FramePass pass(jobs);
    const Vec3f grey(0.5f);
    PoseFitResult result;
    result.pose = frame.pose;
    result.lossBefore = result.lossAfter = pass.run(subject, frame.pose, fine, settings.loss, grey, false).total;

    Pose pose = frame.pose;
    const size_t joints = avatar.joints.size();
    AdamVector adam;
    std::vector<double> gradient(joints * 3 + 3), rates(joints * 3 + 3);
    for (uint32_t i = 0; i < settings.iterations; ++i) {
        const Vec3f background(float(hashUniform(settings.seed, 20, 3 * i)), float(hashUniform(settings.seed, 20, 3 * i + 1)),
                               float(hashUniform(settings.seed, 20, 3 * i + 2)));
        const bool late = 2 * i >= settings.iterations;
        pass.run(subject, pose, late ? fine : coarse, settings.loss, background, true);
        const PoseGradient<double>& g = pass.poseGradient();
        const double fall = std::pow(settings.end, double(i) / settings.iterations);
        for (size_t j = 0; j < joints; ++j) {
            const Vec3d away =
                logQuaternion(Quatd(pose.localRotations[j]) * glm::conjugate(glm::normalize(Quatd(frame.pose.localRotations[j]))));
            for (int a = 0; a < 3; ++a)
                gradient[j * 3 + size_t(a)] = g.rotation[j][a] + 2.0 * settings.posePull * away[a],
                                 rates[j * 3 + size_t(a)] = settings.rateRotation * fall;
        }
        for (int a = 0; a < 3; ++a)
            gradient[joints * 3 + size_t(a)] = g.rootTranslation[a], rates[joints * 3 + size_t(a)] = settings.rateTranslation * fall;
        const std::vector<double> delta = adam.step(gradient, rates);
        for (size_t j = 0; j < joints; ++j)
            pose.localRotations[j] = Quatf(
                glm::normalize(turnQuaternion(-Vec3d(delta[j * 3], delta[j * 3 + 1], delta[j * 3 + 2])) * Quatd(pose.localRotations[j])));
        for (int a = 0; a < 3; ++a) pose.rootTranslation[a] -= float(delta[joints * 3 + size_t(a)]);
        const bool last = i + 1 == settings.iterations;
        if (last || (late && i % 10 == 9)) {
            const double loss = pass.run(subject, pose, fine, settings.loss, grey, false).total;
            if (loss < result.lossAfter) result.lossAfter = loss, result.pose = pose;
        }
    }
    return result;
}

}  // namespace dpl
