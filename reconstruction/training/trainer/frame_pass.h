// SPDX-License-Identifier: Apache-2.0
// Forward and backward pass of one picture: pose the mesh, draw it, compare, and propagate the gradient. Training, polish and pose fit
// share it.
#pragma once

#include "reconstruction/training/trainer/backward_correctives.h"
#include "reconstruction/training/trainer/backward_splats.h"
#include "reconstruction/training/trainer/losses.h"
#include "reconstruction/training/trainer/step_clock.h"
#include "reconstruction/training/trainer/train_images.h"
#include "reconstruction/training/trainer/training_engine.h"
#include "sdk/avatar/posed_mesh.h"

namespace dpl {

/** The avatar to draw, borrowed. mesh.restPositions plus the correctives' offsets are skinned. */
struct PassSubject {
    const TrainableSplats& splats;
    const MeshData& mesh;
    const PoseCorrectiveData& correctives;
    std::span<const JointData> joints;
    TrianglesAtRest rest;
    const VertexIncidence& incidence;
    const LightData& light;
    std::span<const Vec3f> normals;  // V, of RestNormals; empty without light
};

class FramePass {
public:
    explicit FramePass(Jobs& jobs) : jobs_(jobs), engine_(jobs), loss_(jobs), pixels_(jobs), splatBackward_(jobs) {}

    /** Returns the loss of the picture and computes the gradients of the splats. With `geometry`, also fills restGradient(),
     *  poseGradient() and nodeGradient(). */
    LossValues run(const PassSubject& subject, const Pose& pose, const LevelFrame& level, const LossWeights& weights,
                   const Vec3f& background, bool geometry);
    /** The same with an engine that holds subject.splats, and that updates them unless `update` is null; always with geometry. Errors:
     * those of the engine. */
    Result<LossValues> run(const PassSubject& subject, const Pose& pose, const LevelFrame& level, const LossWeights& weights,
                           const Vec3f& background, TrainingEngine& engine, const SplatUpdate* update);

    SplatBackward& splatBackward() { return splatBackward_; }
    const std::vector<Vec3f>& restGradient() const { return gRest_; }
    const PoseGradient<double>& poseGradient() const { return poseGradient_; }
    /** ∂loss/∂(control nodes at this pose), M entries; empty without correctives. */
    std::span<const Vec4f> nodeGradient() const { return gNodes_; }
    const PosedMesh& posed() const { return posed_; }
    const SplatImage& image() const { return image_; }
    const SplatEngine& engine() const { return engine_; }
    StepClock clock;  // of all passes so far; a training step adds its own parts

private:
    void poseSubject(const PassSubject& subject, const Pose& pose);
    /** From the gradients on posed vertices to those of mesh, pose and nodes. */
    void backwardMesh(const PassSubject& subject, const Pose& pose);

    Jobs& jobs_;
    SplatEngine engine_;
    PictureLoss loss_;
    PixelBackward pixels_;
    SplatBackward splatBackward_;
    SplatImage image_;
    ImageGradient gradient_;
    PosedMesh posed_;
    std::vector<Vec3f> gPosed_, gRest_;
    std::vector<float> gLight_;
    std::vector<Vec4f> gNodes_;
    PoseGradient<double> poseGradient_;
};

}  // namespace dpl
