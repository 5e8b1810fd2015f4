// SPDX-License-Identifier: Apache-2.0
// Everything a training run carries from step to step. Private to co_optimise.cpp and checkpoint.cpp.
#pragma once

#include <optional>

#include "reconstruction/shape/large_steps.h"
#include "reconstruction/splat/co_optimise.h"

namespace dpl {

struct CoOptimiser::State {
    State(CoOptimiseInput in, const CoOptimiseSettings& s, Jobs& j) : input(std::move(in)), settings(s), jobs(j), pass(j) {}

    // Fixed for the run.
    CoOptimiseInput input;
    CoOptimiseSettings settings;
    Jobs& jobs;
    std::vector<Vec3f> templatePositions;
    std::vector<RestTriangle<float>> bind;  // D of the template: constant in training
    std::vector<float> referenceSizeM;      // per triangle, for the scale hinge and splits
    VertexIncidence incidence;
    std::optional<MeshRegulariser> meshRegulariser;
    std::optional<LargeSteps> largeSteps;
    std::vector<Pose> firstPoses;
    std::vector<uint32_t> usedFrames;

    // Goes into a checkpoint.
    uint32_t step = 0;
    TrainableSplats splats;
    AdamRows adam;
    DensityStatistics statistics;
    std::vector<Vec3f> u;  // LargeSteps parameters
    AdamUniform adamOffsets;
    AdamRows adamNodes;                  // of input.correctives.nodes: a row a node
    std::vector<Vec3f> restGradientSum;  // since the last LargeSteps update
    uint32_t restGradientCount = 0;
    std::vector<Pose> poses;
    std::vector<AdamVector> adamPoses;
    std::vector<Vec3d> cameraTurn, cameraShift;  // X_view ← exp(turn)·X_view + shift of the given camera
    std::vector<AdamVector> adamCameras;
    std::vector<CurvePoint> curve;
    double sumLoss = 0, sumL1 = 0, sumSsim = 0, sumMask = 0, sumSquared = 0, sumSquaredCount = 0;
    uint32_t sumSteps = 0;

    // Follows from the above.
    MeshData mesh;  // input.mesh at template + ΔVˢ
    std::vector<LevelFrame> level;
    int levelIndex = -1;
    std::vector<uint32_t> order;
    uint64_t orderEpoch = ~0ull;
    FramePass pass;
    StepProfile profile;

    Status prepare();
    Status stepOnce();
    void applyOffsets();
    bool learnsCorrectives() const { return settings.learnCorrectives && !input.correctives.empty(); }
    void selectLevel();
    uint32_t frameOf(uint32_t atStep);
    Camerad cameraOf(uint32_t frame) const;
    void updateSplats(uint32_t frame);
    void updatePose(uint32_t frame);
    void updateOffsets();
    void updateCorrectives();
    float decay(float end) const;
    CurvePoint recentPoint() const;
    uint64_t fingerprint() const;  // of input sizes and settings: a checkpoint of another run is refused
};

}  // namespace dpl
