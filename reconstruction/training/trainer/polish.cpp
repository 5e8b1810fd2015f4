// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/polish.h"

#include <cmath>

#include "reconstruction/training/trainer/pose_step.h"
#include "reconstruction/training/trainer/random.h"
#include "sdk/avatar/scene_light.h"

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
    DPL_TRY(const auto picture, checkedPicture(frame));
    DPL_RETURN_IF_ERROR(checkPose(avatar.joints, frame.pose));
    DPL_RETURN_IF_ERROR(checkPrecision(frame, avatar.joints.size()));
    LevelFrame coarse = makeLevelFrame(frame, *picture, std::max(0.5f, coarsestScale(frame)), {}, false),
               fine = makeLevelFrame(frame, *picture, 1, {}, true);
    coarse.kappaPx2 = fine.kappaPx2 = avatar.kappaPx2;
    if (!fine.used) return fail(Code::InvalidArgument, "frame '{}': nobody is in its mask, so its pose cannot be fitted", frame.name);
    const std::vector<float> floors(avatar.mesh.triangles.size(), 0.0f);
    TrainableSplats splats = TrainableSplats::fromSplatData(avatar.splats, floors);
    splats.activateAll(jobs);
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    const VertexIncidence incidence(avatar.mesh.triangles, avatar.mesh.restPositions.size());
    std::vector<Vec3f> normals;
    if (!avatar.light.empty()) normals = restVertexNormals(avatar.mesh);
    const PassSubject subject{splats, avatar.mesh, avatar.correctives, avatar.joints, {bind}, incidence, avatar.light, normals};
    FramePass pass(jobs);
    const Vec3f grey(0.5f);
    PoseFitResult result;
    result.pose = frame.pose;
    result.lossBefore = result.lossAfter = pass.run(subject, frame.pose, fine, settings.loss, grey, false).total;

    // Nats of picture and registration together; the picture's likelihood is that of lossPerNat().
    const double natsPerLog = 1 / lossPerNat(1, fine.personPx, settings.pictureTrust);
    const auto nats = [&](double loss, const PosePull& pull, const Pose& pose) {
        return natsPerLog * std::log(std::max(1e-9, loss)) + costOfDeviation(pose, pull);
    };
    PosePrecision precision;
    if (frame.precision) {
        const Vec3d view = Vec3d(rootPosition(avatar.joints, frame.pose)) - frame.camera.cast<double>().eye();
        precision = heldAlong(*frame.precision, glm::normalize(view), settings.pictureTrust / settings.depthTrust);
    }
    PosePull pull{frame.pose, frame.precision ? &precision : nullptr};
    double best = nats(result.lossBefore, pull, frame.pose);
    Pose pose = frame.pose;
    AdamVector adam;
    for (uint32_t i = 0; i < settings.iterations; ++i) {
        const Vec3f background(float(hashUniform(settings.seed, 20, 3 * i)), float(hashUniform(settings.seed, 20, 3 * i + 1)),
                               float(hashUniform(settings.seed, 20, 3 * i + 2)));
        const bool late = 2 * i >= settings.iterations;
        const LevelFrame& level = late ? fine : coarse;
        const double loss = pass.run(subject, pose, level, settings.loss, background, true).total;
        const double fall = std::pow(settings.end, double(i) / settings.iterations);
        pull.lossPerNat = lossPerNat(loss, level.personPx, settings.pictureTrust);
        stepPose(pose, adam, pass.poseGradient(), {settings.rateRotation * fall, settings.rateTranslation * fall}, pull);
        const bool last = i + 1 == settings.iterations;
        if (last || (late && i % 10 == 9)) {
            const double after = pass.run(subject, pose, fine, settings.loss, grey, false).total, now = nats(after, pull, pose);
            if (now < best) best = now, result.lossAfter = after, result.pose = pose;
        }
    }
    return result;
}

}  // namespace dpl
