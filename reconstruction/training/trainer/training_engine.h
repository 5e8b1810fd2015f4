// SPDX-License-Identifier: Apache-2.0
// The seam between a training and a device that keeps its splats: draws them, compares, updates them, and hands back what the mesh and the
// pose need. Without an engine the trainer does all of it on the CPU. reconstruction/training/gpu holds the engine for GPUs.
#pragma once

#include "reconstruction/training/trainer/adam.h"
#include "reconstruction/training/trainer/backward_mesh.h"
#include "reconstruction/training/trainer/density.h"
#include "reconstruction/training/trainer/losses.h"
#include "reconstruction/training/trainer/regularisers.h"
#include "sdk/core/pass_time.h"
#include "sdk/math/camera.h"

namespace dpl {

/** What the updates of all splats of a step share. */
struct SplatUpdate {
    bool counts = false;      // towards density control
    float halfHeight = 0;     // px; makes a gradient per pixel one per half a picture
    std::vector<float> rate;  // of each column of a row
    RegulariserWeights regularise;
};

/** All that an engine keeps between steps, and what does not change while it does. Borrowed for the call. */
struct EngineState {
    const TrainableSplats& splats;
    const AdamRows& adam;
    const DensityStatistics& statistics;
    std::span<const uint8_t> learns;        // F: whether splats of a triangle learn
    std::span<const float> referenceSizeM;  // F
    const VertexIncidence& incidence;
    std::span<const Triangle> triangles;        // F; corners below the number of vertices of `incidence`
    std::span<const RestTriangle<float>> bind;  // F, at rest; splat sizes refer to them
};

/** What a training needs at most, to refuse it before it begins. */
struct EngineRoom {
    uint32_t splats = 0, triangles = 0, vertices = 0, shDegree = 0;
    uint64_t picturePx = 0;  // of the largest picture
};

/** One picture. Borrowed for the call. */
struct EngineStep {
    std::span<const Vec3f> positions;  // V, posed, world
    std::span<const float> light;      // V, brightness; empty: 1
    const Cameraf& camera;             // of the target
    float kappaPx2 = 0;
    PictureTarget target;
    std::optional<TargetName> name;  // of the target; none: it is not kept
    LossWeights weights;
    Vec3f background{0};
    const SplatUpdate* update = nullptr;  // null: splats stay as they are
};

/** One thread at a time. The same engine on the same device gives the same bytes for the same calls; two engines agree in decibels. */
class TrainingEngine {
public:
    virtual ~TrainingEngine() = default;

    /** What computes, for people: "NVIDIA H200". */
    virtual std::string name() const = 0;
    /** A training begins: targets of the one before are forgotten. OutOfMemory: the device has too little memory for it; the message has
     *  its name, both numbers and the remedy. */
    virtual Status begin(const EngineRoom& most) = 0;
    /** Takes the state, in place of the one before; triangles at rest are those of `bind` again. OutOfMemory, Device: the device failed. */
    virtual Status upload(const EngineState& state) = 0;
    /** The triangles at rest as training has moved them: stretch is measured from them from the next step on. */
    virtual Status setRest(std::span<const RestTriangle<float>> now) = 0;
    /** Draws, compares, and updates the splats. The loss is that before the update. InvalidArgument: the step does not fit the state. */
    virtual Result<LossValues> step(const EngineStep& step) = 0;
    /** V: ∂loss/∂(posed vertex), and in w ∂loss/∂(its brightness), of the last step. Valid until the next call. */
    virtual std::span<const Vec4f> vertexGradients() const = 0;
    /** Times of the passes of the last step on the device; empty where it has no clock. */
    virtual std::vector<PassTime> passTimes() = 0;
    /** Bytes of steps, triangles at rest and targets that went to the device or came back since the last call. */
    virtual uint64_t takeCrossedBytes() = 0;
    /** The state back; its triangles and flags are those that were uploaded. */
    virtual Status download(TrainableSplats& splats, AdamRows& adam, DensityStatistics& statistics) = 0;
};

}  // namespace dpl
