#include "reconstruction/splat/frame_pass.h"

#include <chrono>

namespace dpl {

LossValues FramePass::run(const PassSubject& s, const Pose& pose, const LevelFrame& level, const Cameraf& camera, const LossWeights& weights,
                          const Vec3f& background, bool geometry) {
    auto last = std::chrono::steady_clock::now();
    const auto lap = [&last](double& sum) {
        const auto now = std::chrono::steady_clock::now();
        sum += std::chrono::duration<double, std::milli>(now - last).count();
        last = now;
    };
    jointTransforms(s.joints, pose, transforms_);
    skin(s.mesh, transforms_, jobs_, posed_);
    poseTriangles(s.mesh, s.bind, posed_, jobs_, frames_);
    lap(times.pose);
    engine_.project(s.splats.view(), frames_, camera, level.kappaPx2);
    engine_.bin();
    lap(times.project);
    engine_.blend(image_, {.cloth = weights.cloth > 0 && !level.cloth.empty(), .depth = false, .recordStops = true});
    lap(times.blend);
    level.fill(target_);
    const LossValues v = loss_.run(image_, target_, weights, background, gradient_);
    lap(times.loss);
    pixels_.run(engine_, image_, gradient_);
    lap(times.pixels);
    splatBackward_.run({s.splats, frames_, s.bind, camera, level.kappaPx2, engine_.projected(), pixels_.sums()}, geometry);
    lap(times.splats);
    if (geometry) {
        splatBackward_.gatherVertices(s.incidence, gPosed_);
        backwardSkin(s.mesh, s.mesh.restPositions, s.joints, transforms_, posed_, gPosed_, camera.viewFromWorldRotation, camera.viewFromWorldTranslation,
                     jobs_, gRest_, poseGradient_);
        lap(times.mesh);
    }
    return v;
}

}  // namespace dpl
