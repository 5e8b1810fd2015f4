// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/pose_fitter.h"

#include <atomic>
#include <cmath>

#include "reconstruction/training/trainer/pose_step.h"
#include "reconstruction/training/trainer/random.h"
#include "sdk/avatar/scene_light.h"
#include "sdk/core/task.h"

namespace dpl {
PoseFitter::PoseFitter(const AvatarData& avatar, Jobs& jobs)
    : avatar_(avatar), bind_(restTriangles(avatar.mesh)), incidence_(avatar.mesh.triangles, avatar.mesh.restPositions.size()) {
    const std::vector<float> floors(avatar.mesh.triangles.size(), 0.0f);
    splats_ = TrainableSplats::fromSplatData(avatar.splats, floors);
    splats_.activateAll(jobs);
    if (!avatar.light.empty()) normals_ = restVertexNormals(avatar.mesh);
}

Result<PoseFitResult> PoseFitter::fit(const TrainFrame& frame, const PoseFitSettings& settings, Jobs& jobs, const Pose* from) const {
    DPL_TRY(const auto picture, checkedPicture(frame));
    DPL_RETURN_IF_ERROR(checkPose(avatar_.joints, frame.pose));
    if (from) DPL_RETURN_IF_ERROR(checkPose(avatar_.joints, *from));
    DPL_RETURN_IF_ERROR(checkPrecision(frame, avatar_.joints.size()));
    LevelFrame coarse = makeLevelFrame(frame, *picture, std::max(0.5f, coarsestScale(frame)), {}, false),
               fine = makeLevelFrame(frame, *picture, 1, {}, true);
    coarse.kappaPx2 = fine.kappaPx2 = avatar_.kappaPx2;
    if (!fine.used) return fail(Code::InvalidArgument, "frame '{}': nobody is in its mask, so its pose cannot be fitted", frame.name);
    const PassSubject subject{splats_, avatar_.mesh, avatar_.correctives, avatar_.joints, {bind_}, incidence_, avatar_.light, normals_};
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
        const Vec3d view = Vec3d(rootPosition(avatar_.joints, frame.pose)) - frame.camera.cast<double>().eye();
        precision = heldAlong(*frame.precision, glm::normalize(view), settings.pictureTrust / settings.depthTrust);
    }
    PosePull pull{frame.pose, frame.precision ? &precision : nullptr};
    double best = nats(result.lossBefore, pull, frame.pose);
    const auto meet = [&](const Pose& pose) {
        const double after = pass.run(subject, pose, fine, settings.loss, grey, false).total, now = nats(after, pull, pose);
        if (now < best) best = now, result.lossAfter = after, result.pose = pose;
    };
    Pose pose = from ? *from : frame.pose;
    if (from) meet(pose);
    AdamVector adam;
    for (uint32_t i = from ? uint32_t((1 - kSecondFit) * settings.iterations) : 0; i < settings.iterations; ++i) {
        const Vec3f background(float(hashUniform(settings.seed, 20, 3 * i)), float(hashUniform(settings.seed, 20, 3 * i + 1)),
                               float(hashUniform(settings.seed, 20, 3 * i + 2)));
        const bool late = 2 * i >= settings.iterations;
        const LevelFrame& level = late ? fine : coarse;
        const double loss = pass.run(subject, pose, level, settings.loss, background, true).total;
        const double fall = std::pow(settings.end, double(i) / settings.iterations);
        pull.lossPerNat = lossPerNat(loss, level.personPx, settings.pictureTrust);
        stepPose(pose, adam, pass.poseGradient(), {settings.rateRotation * fall, settings.rateTranslation * fall}, pull);
        const bool last = i + 1 == settings.iterations;
        if (last || (late && i % 10 == 9)) meet(pose);
    }
    return result;
}

Result<std::vector<std::optional<PoseFitResult>>> PoseFitter::fitAll(std::span<const TrainFrame> frames, const PoseFitSettings& settings,
                                                                     Jobs& jobs, std::span<const std::optional<PoseFitResult>> from) const {
    std::vector<std::optional<PoseFitResult>> fits(frames.size());
    std::atomic<bool> stopped{false};
    std::atomic<size_t> done{0};
    Status goesOn;  // of the calling thread, which is worker 0
    jobs.forBlocks(frames.size(), [&](size_t f, uint32_t worker) {
        if (stopped) return;
        if (worker == 0) {
            goesOn = taskAt(double(done) / double(frames.size()), frames[f].name);
            if (!goesOn) stopped = true;
        }
        if (stopped) return;
        Jobs alone(1);
        const Pose* start = f < from.size() && from[f] ? &from[f]->pose : nullptr;
        if (auto fitted = fit(frames[f], settings, alone, start)) fits[f] = std::move(*fitted);
        ++done;
    });
    DPL_RETURN_IF_ERROR(goesOn);
    return fits;
}

}  // namespace dpl
