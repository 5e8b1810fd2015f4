// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/frame_pass.h"

#include <chrono>

namespace dpl {

LossValues FramePass::run(const PassSubject& s, const Pose& pose, const LevelFrame& level, const LossWeights& weights,
                          const Vec3f& background, bool geometry) {
    auto last = std::chrono::steady_clock::now();
    const auto lap = [&last](double& sum) {
        const auto now = std::chrono::steady_clock::now();
        sum += std::chrono::duration<double, std::milli>(now - last).count();
        last = now;
    };
    posed_.pose({s.joints, s.mesh, s.correctives, s.rest, &s.light, s.normals}, pose, jobs_);
    lap(times.pose);
    engine_.project(s.splats.view(), posed_.frames(), level.camera, level.kappaPx2, /*compensated=*/true, /*record=*/true);
    engine_.bin();
    lap(times.project);
    engine_.blend(image_, {.cloth = weights.cloth > 0 && !level.cloth.empty(), .depth = false, .recordStops = true});
    lap(times.blend);
    const LossValues v = loss_.run(image_, level.target(), weights, background, gradient_);
    lap(times.loss);
    pixels_.run(engine_, image_, gradient_);
    lap(times.pixels);
    splatBackward_.run({s.splats, posed_.frames(), s.rest, level.camera, engine_.projected(), engine_.forwardRecords(), pixels_.sums()},
                       geometry);
    lap(times.splats);
    if (geometry) {
        splatBackward_.gatherVertices(s.incidence, gPosed_, gLight_);
        backwardSceneLight(posed_, gLight_);
        backwardSkin(s.mesh, s.joints, posed_, gPosed_, jobs_, gRest_, poseGradient_);
        gNodes_.clear();
        if (!s.correctives.empty()) {
            gatherNodes(s.correctives, posed_.nodes(), gRest_, gLight_, gNodes_);
            addCorrectivePoseGradient(s.correctives, pose, gNodes_, poseGradient_.rotation);
        }
        lap(times.mesh);
    }
    return v;
}

}  // namespace dpl
