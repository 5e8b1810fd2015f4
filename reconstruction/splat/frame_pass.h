// One picture forward and backward: pose the mesh, draw, compare, and bring the gradient back. Shared by training, polish and pose fit.
#pragma once

#include "reconstruction/splat/backward_splats.h"
#include "reconstruction/splat/losses.h"
#include "reconstruction/splat/train_images.h"

namespace dpl {

/** What is drawn, borrowed. `mesh.restPositions` are skinned; `bind` are the triangles that splat sizes refer to. */
struct PassSubject {
    const TrainableSplats& splats;
    const MeshData& mesh;
    std::span<const JointData> joints;
    std::span<const RestTriangle<float>> bind;
    const VertexIncidence& incidence;
};

/** Wall time of the parts, summed over passes, milliseconds. */
struct PassTimes {
    double pose = 0, project = 0, blend = 0, loss = 0, pixels = 0, splats = 0, mesh = 0;
};

class FramePass {
public:
    explicit FramePass(Jobs& jobs) : jobs_(jobs), engine_(jobs), loss_(jobs), pixels_(jobs), splatBackward_(jobs) {}

    /** geometry: also fill restGradient() and poseGradient(). `camera` replaces the level's (same size). */
    LossValues run(const PassSubject& subject, const Pose& pose, const LevelFrame& level, const Cameraf& camera, const LossWeights& weights,
                   const Vec3f& background, bool geometry);
    LossValues run(const PassSubject& subject, const Pose& pose, const LevelFrame& level, const LossWeights& weights, const Vec3f& background, bool geometry) {
        return run(subject, pose, level, level.camera, weights, background, geometry);
    }

    SplatBackward& splatBackward() { return splatBackward_; }
    const std::vector<Vec3f>& restGradient() const { return gRest_; }
    const PoseGradient<double>& poseGradient() const { return poseGradient_; }
    const SplatImage& image() const { return image_; }
    const SplatEngine& engine() const { return engine_; }
    PassTimes times;

private:
    Jobs& jobs_;
    SplatEngine engine_;
    PictureLoss loss_;
    PixelBackward pixels_;
    SplatBackward splatBackward_;
    SplatImage image_;
    PictureTarget target_;
    ImageGradient gradient_;
    std::vector<Mat3x4f> transforms_;
    std::vector<Vec3f> posed_, gPosed_, gRest_;
    std::vector<TriangleFrame<float>> frames_;
    PoseGradient<double> poseGradient_;
};

}  // namespace dpl
