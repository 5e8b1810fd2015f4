// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/frame_pass.h"

namespace dpl {

void FramePass::poseSubject(const PassSubject& s, const Pose& pose) {
    posed_.pose({s.joints, s.mesh, s.correctives, s.rest, &s.light, s.normals}, pose, jobs_);
}

void FramePass::backwardMesh(const PassSubject& s, const Pose& pose) {
    backwardSceneLight(posed_, gLight_);
    backwardSkin(s.mesh, s.joints, posed_, gPosed_, jobs_, gRest_, poseGradient_);
    gNodes_.clear();
    if (s.correctives.empty()) return;
    gatherNodes(s.correctives, posed_.nodes(), gRest_, gLight_, gNodes_);
    addCorrectivePoseGradient(s.correctives, pose, gNodes_, poseGradient_.rotation);
}

LossValues FramePass::run(const PassSubject& s, const Pose& pose, const LevelFrame& level, const LossWeights& weights,
                          const Vec3f& background, bool geometry) {
    clock.start();
    poseSubject(s, pose);
    clock.lap(StepPart::Pose);
    engine_.project(s.splats.view(), posed_.frames(), level.camera, level.kappaPx2, /*compensated=*/true, /*record=*/true);
    clock.lap(StepPart::Project);
    engine_.bin();
    clock.lap(StepPart::Tiles);
    engine_.blend(image_, {.cloth = weights.cloth > 0 && !level.cloth.empty(), .depth = false, .recordStops = true});
    clock.lap(StepPart::Blend);
    const LossValues v = loss_.run(image_, level.target(), weights, background, gradient_);
    clock.lap(StepPart::Loss);
    pixels_.run(engine_, image_, gradient_);
    clock.lap(StepPart::Pixels);
    splatBackward_.run({s.splats, posed_.frames(), s.rest, level.camera, engine_.projected(), engine_.forwardRecords(), pixels_.sums()},
                       geometry);
    clock.lap(StepPart::Splats);
    if (geometry) {
        splatBackward_.gatherVertices(s.incidence, gPosed_, gLight_);
        backwardMesh(s, pose);
        clock.lap(StepPart::Mesh);
    }
    return v;
}

Result<LossValues> FramePass::run(const PassSubject& s, const Pose& pose, const LevelFrame& level, const LossWeights& weights,
                                  const Vec3f& background, TrainingEngine& engine, const SplatUpdate* update) {
    clock.start();
    posed_.poseVertices({s.joints, s.mesh, s.correctives, s.rest, &s.light, s.normals}, pose, jobs_);
    clock.lap(StepPart::Pose);
    DPL_TRY(const LossValues loss, engine.step({posed_.positions(), posed_.light(), level.camera, level.kappaPx2, level.target(),
                                                level.name, weights, background, update}));
    clock.lap(StepPart::Engine);
    const auto vertices = engine.vertexGradients();
    gPosed_.resize(vertices.size()), gLight_.resize(vertices.size());
    for (size_t v = 0; v < vertices.size(); ++v) gPosed_[v] = Vec3f(vertices[v]), gLight_[v] = vertices[v].w;
    backwardMesh(s, pose);
    clock.lap(StepPart::Mesh);
    return loss;
}

}  // namespace dpl
