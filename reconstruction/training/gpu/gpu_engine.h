// SPDX-License-Identifier: Apache-2.0
// Training on a GPU, by Vulkan or Metal (docs/reference/gpu-training.md). The splats, their rows and moments and the targets stay on the
// device; of a step the posed vertices go there, and the loss and their gradients come back. The kernels are in shaders/training, their
// order in gpu_steps.cpp.
//
// The same device gives the same bytes for the same calls: no sum depends on which lane comes first.
#pragma once

#include <memory>

#include "reconstruction/training/gpu/gpu_buffers.h"
#include "reconstruction/training/gpu/gpu_targets.h"
#include "reconstruction/training/trainer/training_engine.h"
#include "sdk/backend/shader_pack.h"

namespace dpl {

/** Gradients of the last step, for tests. */
struct GpuGradients {
    std::span<const float> rows;          // N × stride; rows of splats that no pixel shows hold anything
    std::span<const float> screenLength;  // N: |∂loss/∂(centre on the screen)|, per pixel; negative: no pixel shows the splat
};

/** What the kernels ask of a device. */
struct KernelNeeds {
    uint32_t storageBuffers = 0, sharedBytes = 0;
};
KernelNeeds needsOf(const ShaderPack& kernels);

class GpuEngine final : public TrainingEngine {
public:
    /** On a backend with the kernels of shaders/training. Unsupported: the device gives them less than they need. */
    static Result<std::unique_ptr<GpuEngine>> create(std::unique_ptr<Backend> backend, const KernelNeeds& needs);
    ~GpuEngine() override;

    std::string name() const override;
    Status begin(const EngineRoom& most) override;
    Status upload(const EngineState& state) override;
    Status setRest(std::span<const RestTriangle<float>> now) override;
    Result<LossValues> step(const EngineStep& step) override;
    std::span<const Vec4f> vertexGradients() const override;
    std::vector<PassTime> passTimes() override;
    uint64_t takeCrossedBytes() override { return std::exchange(crossedBytes_, 0); }
    Status download(TrainableSplats& splats, AdamRows& adam, DensityStatistics& statistics) override;

    const DeviceInfo& device() const { return backend_->info(); }
    /** Graphics memory of the state and of the largest picture so far. */
    uint64_t residentBytes() const { return backend_->residentBytes(); }
    /** Entries of the tile lists of the last step. */
    uint32_t entries() const { return entries_; }
    /** Valid until the next call. */
    Result<GpuGradients> gradients();

private:
    explicit GpuEngine(std::unique_ptr<Backend> backend) : backend_(std::move(backend)), targets_(*backend_) {}
    Status checkStep(const EngineStep& step) const;
    /** Waits for the update of the last step, which runs while the host moves the mesh and poses the next picture. */
    Status settle();
    Status holdPicture(const GpuPictureSizes& needed);
    void dropPicture();
    void fill(const EngineStep& step);
    LossValues lossOf(const EngineStep& step) const;

    std::unique_ptr<Backend> backend_;
    GpuTargets targets_;
    GpuStateSizes sizes_;
    std::unique_ptr<GpuState> state_;
    std::unique_ptr<GpuPicture> picture_;
    std::vector<RestTriangle<float>> bind_;
    uint32_t entries_ = 0, shDegree_ = 0;
    uint64_t crossedBytes_ = 0;
};

}  // namespace dpl
