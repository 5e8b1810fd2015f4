// SPDX-License-Identifier: Apache-2.0
// Co-optimisation: learns splats, static offsets ΔVˢ and per-frame poses together from the training pictures.
//
// A step draws one frame (FramePass) and updates the visible splats and the frame's pose with Adam. Every fourth step updates ΔVˢ with
// LargeSteps. Density control runs at intervals, and the resolution rises by levels. The result is the same, byte for byte, on any number
// of threads; it depends on the input, the settings and their seed only.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "reconstruction/training/trainer/density.h"
#include "reconstruction/training/trainer/frame_pass.h"
#include "reconstruction/training/trainer/init.h"
#include "reconstruction/training/trainer/level_frames.h"
#include "reconstruction/training/trainer/priors.h"
#include "reconstruction/training/trainer/training_engine.h"

namespace dpl {

/** What is trained, and from which pictures. Training does not change it. */
struct CoOptimiseInput {
    std::vector<JointData> joints;
    MeshData mesh;                                        // template at rest; weights already quantised to 4 × unorm8
    PoseCorrectiveData correctives;                       // start values (nodes usually zero); empty: none are learned
    LightData light;                                      // of the scene; constant
    std::vector<uint8_t> triangleLabel;                   // F label values of the scan, or empty: all body
    std::vector<TrainFrame> frames;                       // training frames only
    std::vector<Pose> stress;                             // poses that garments are also pulled out of the body in; may be empty
    uint64_t levelBoundBytes = LevelFrames::kBoundBytes;  // memory for frames at the current level; changes no result
};

/** The input for training `avatar` on. frames: with the poses that it was trained with. */
CoOptimiseInput inputOf(const AvatarData& avatar, std::vector<uint8_t> triangleLabel, std::vector<TrainFrame> frames);

struct CoOptimiseSettings {
    uint64_t seed = 1;
    uint32_t steps = 8000;
    InitSettings init;
    uint32_t maxSplats = 90000;
    LossWeights loss{0.8f, 0.2f, 0.3f, 0.1f};
    float earlyMaskFactor = 5.0f;  // multiplies the mask weight in the first quarter of the run
    RegulariserWeights regularise;
    float closeupStepScale = 5.0f;  // multiplies Adam's steps of splats in close-ups (docs/reference/losses.md, "Gradient control")
    bool learnSplats = true;
    bool learnGeometry = true;
    bool learnPoses = true;
    bool learnCorrectives = true;
    bool learnMotion = true;  // false: the stage makes no motion modes
    bool learnLight = true;   // false: the stage looks for no light of the scene
    bool densify = true;
    bool learnPlacement = true;       // uv and φ; off in polish
    bool fullResolutionOnly = false;  // no progressive levels
    // Learning rates at the start. Each falls geometrically to its `end` factor times its start.
    float rateUv = 1e-2f, endUv = 0.02f;
    float ratePhi = 2e-3f, rateLogScale = 1e-2f, endLogScale = 0.2f;
    float rateOpacity = 5e-2f, endOpacity = 0.2f;
    float rateDc = 5e-3f, rateRest = 2.5e-4f, endColour = 0.2f;
    float rateOffsets = 5e-3f, endOffsets = 0.1f;  // metres, AdamUniform on u
    float rateRotation = 1.5e-3f, rateTranslation = 1e-3f, endPose = 0.1f;
    float rateNodeOffset = 2e-4f, rateNodeLight = 4e-3f, endNodes = 0.1f;  // metres and brightness a unit of a mode
    float nodeDecay = 2e-3f;  // share by which a step shrinks the nodes of its frame; falls like the node rates
    double smoothingLengthM = priors::kTrainingSmoothingM;
    uint32_t geometryEvery = 4;   // steps for one LargeSteps update, which takes the mean of their gradients
    uint32_t densityEvents = 20;  // spread between 8 % and 55 % of the run
    std::vector<float> levelStarts{0.0f, 0.25f, 0.35f, 0.45f, 0.55f};  // fractions of the run; first level coarsest, last level full size
};

struct CurvePoint {
    uint32_t step = 0;
    float loss = 0, l1 = 0, ssim = 0, mask = 0, psnr = 0;  // means since the point before; ssim is 1 − SSIM, psnr in dB
    uint32_t splats = 0;
};

/** Speed of training steps, as means over the last epoch. The avatar does not depend on it. */
struct StepProfile {
    uint32_t steps = 0;
    double stepMs = 0;
    PartTimes parts{};
    double pairs = 0, entries = 0;                       // pixel-splat pairs a step; entries of tile lists
    double visible = 0, pixels = 0;                      // splats that a step draws; pixels of its picture
    double forwardNsPerPair = 0, backwardNsPerPair = 0;  // of the blend and of its backward pass
};

struct CoOptimiseResult {
    SplatData splats;                  // bound to `restPositions`
    std::vector<Vec3f> restPositions;  // template + ΔVˢ
    PoseCorrectiveData correctives;
    LightData light;          // that of the input
    std::vector<Pose> poses;  // refined, in the order of the frames
    std::vector<CurvePoint> curve;
    StepProfile profile;
    uint32_t framesUsed = 0;
};

class CoOptimiser {
public:
    /** Checks the input and makes the state before the first step. Errors name the frame or the array. `jobs` and `engine` must outlive the
     *  trainer. engine: keeps, draws and updates the splats; null: the CPU does. */
    static Result<std::unique_ptr<CoOptimiser>> create(CoOptimiseInput input, const CoOptimiseSettings& settings, Jobs& jobs,
                                                       TrainingEngine* engine = nullptr);
    /** Like create(), but starts from given splats, which are bound to input.mesh. Polish uses it. */
    static Result<std::unique_ptr<CoOptimiser>> createFrom(CoOptimiseInput input, const SplatData& splats,
                                                           const CoOptimiseSettings& settings, Jobs& jobs,
                                                           TrainingEngine* engine = nullptr);
    ~CoOptimiser();

    /** Steps until the end, or for maxSteps steps. Cancelled: the task of this thread was; another run() continues. Device, OutOfMemory:
     * the engine failed, and took the splats since the last run() with it; then checkpoint() fails too, and what is left is to start from
     * the last one. */
    Status run(uint32_t maxSteps = ~0u);
    bool finished() const;
    uint32_t step() const;

    /** Writes the whole state to `path`, atomically. A run restored from it ends in the same bytes as an uninterrupted one. */
    Status checkpoint(const std::filesystem::path& path) const;
    /** Reads a state that was written with the same input and settings. Refuses one of another run, a damaged file and numbers that are
     *  not finite; after an error the state is unchanged. */
    Status restore(const std::filesystem::path& path);
    /** Goes on from a state that was written with the same input and other settings. Returns what changed, for people, "steps 3000 to
     * 5000"; empty: nothing. Refuses what restore() refuses, a state with as many steps as this training has, and settings that change what
     * its numbers mean: SH degree, smoothing length. */
    Result<std::string> branch(const std::filesystem::path& path);

    /** Forgets the profile of the steps so far, and starts another one. The last epoch does so by itself. */
    void startProfile();
    StepProfile profile() const;
    /** Mean loss since the last point of the curve. */
    double recentLoss() const;
    uint32_t splatCount() const;

    CoOptimiseResult result() const;
    /** That of the result, without the rest. */
    const std::vector<CurvePoint>& curve() const;

private:
    struct State;
    explicit CoOptimiser(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace dpl
