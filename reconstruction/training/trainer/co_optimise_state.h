// SPDX-License-Identifier: Apache-2.0
// The state of a training run between steps. Private to co_optimise.cpp and checkpoint.cpp.
#pragma once

#include <optional>

#include "reconstruction/subject/shape/large_steps.h"
#include "reconstruction/training/trainer/garment_collision.h"
#include "reconstruction/training/trainer/learned.h"
#include "reconstruction/training/trainer/motion_bounds.h"
#include "sdk/avatar/scene_light.h"

namespace dpl {

struct CoOptimiser::State {
    State(CoOptimiseInput in, const CoOptimiseSettings& s, Jobs& j, TrainingEngine* e)
        : input(std::move(in)),
          settings(s),
          jobs(j),
          engine(e),
          levels(input.frames, s.init.clothLabels, input.levelBoundBytes, j),
          pass(j) {}

    // Constant during the run.
    const CoOptimiseInput input;
    const CoOptimiseSettings settings;
    Jobs& jobs;
    TrainingEngine* const engine;           // null: the CPU
    std::vector<RestTriangle<float>> bind;  // of the template, before offsets
    std::vector<float> referenceSizeM;      // per triangle, for the scale hinge and splits
    std::vector<uint8_t> learns;            // per triangle: splats of unseen triangles of the body stay as they started
    VertexIncidence incidence;
    std::optional<MeshRegulariser> meshRegulariser;
    std::optional<LargeSteps> largeSteps;
    std::optional<GarmentCollision> collision;
    std::optional<MotionBounds> motionBounds;  // none without motion modes
    std::optional<RestNormals> restNormals;    // none without light
    std::vector<uint32_t> usedFrames;
    std::vector<uint64_t> pictureHashes;  // of every frame its image, its mask and its labels
    bool onlyMoving = false;              // no still frame is used

    Learned learned;             // what a checkpoint stores
    bool engineCurrent = false;  // the engine has the splats of `learned`, or those that later steps made of them
    bool engineAhead = false;    // it has later ones
    bool engineRest = false;     // it has restNow
    std::optional<Error> engineLost;

    // Derived from the members above.
    MeshData mesh;                             // input.mesh with the learned offsets ΔVˢ added
    std::vector<RestTriangle<float>> restNow;  // of `mesh`; empty while there are no offsets
    std::vector<Vec3f> normals;                // of `mesh`; empty without light
    LevelFrames levels;
    std::vector<uint32_t> order;
    uint64_t orderEpoch = ~0ull;
    std::vector<Vec3f> collisionGradient;  // of this step, on rest positions; empty in steps without
    std::vector<Vec3f> stressGradient;     // the same in a stress pose, for offsets or, where there are motion modes, for these
    PosedMesh stressed;                    // the subject in one of input.stress
    FramePass pass;
    StepProfile profile;  // sums; their means are those of CoOptimiser::profile()
    bool counts = false;  // pairs, entries, splats and pixels, which takes time

    Status prepare();
    void chooseLearners(const std::vector<uint8_t>& seen);
    void start(TrainableSplats splats);
    void startProfile();
    Status stepOnce();
    /** Fills collisionGradient every geometryEvery steps, and stressGradient every second time. */
    void pullGarments();
    /** Offsets to mesh, its normals and restNow. */
    void applyOffsets();
    /** The same without restNow. One thread. */
    void moveMesh();
    /** The body's vertices come first. Its offsets keep mean zero, because poses tell where it is. */
    uint32_t bodyVertices() const {
        return input.mesh.layers.empty() ? uint32_t(input.mesh.restPositions.size()) : input.mesh.layers.front().vertexCount;
    }
    bool learnsCorrectives() const { return settings.learnCorrectives && !input.correctives.empty(); }
    Status selectLevel();
    uint32_t frameOf(uint32_t atStep);
    /** Updates everything from the gradients of the step. What one thread computes runs beside the splats: none reads what another writes.
     */
    void updateAll(uint32_t frame, const LevelFrame& level, double loss);
    /** Draws the picture of a frame, and propagates its gradient back. An engine also updates the splats. */
    Result<LossValues> passOf(uint32_t frame, const LevelFrame& level, const LossWeights& weights, const Vec3f& background);
    /** Splats, moments and statistics of `learned` as the last step left them. */
    Status bringBack();
    SplatUpdate splatUpdate(uint32_t frame, const LevelFrame& level);
    void updateSplats(const SplatUpdate& update, size_t begin, size_t end);
    void updatePose(uint32_t frame, const LevelFrame& level, double loss);
    void hashPicture(const FramePicture& picture);
    /** Adds the step's gradient, and updates the mesh every geometryEvery steps; restNow is then left to the caller. Whether it did. */
    bool updateOffsets();
    void updateCorrectives();
    /** What a value of a node started at, and decays to. */
    Vec4f startOf(uint32_t node, uint32_t column) const;
    float decay(float end) const;
    CurvePoint recentPoint() const;
    std::string told() const;    // for people: how far it is
    uint64_t inputHash() const;  // of everything that is given, to refuse a checkpoint of another run
    /** What a checkpoint holds, checked, and how its settings differ from these, as text. */
    struct Stored {
        Learned learned;
        std::string changes;
    };
    Result<Stored> read(const std::filesystem::path& path) const;
    void adopt(Learned stored);
};

}  // namespace dpl
