// SPDX-License-Identifier: Apache-2.0
// Forward and backward pass of one picture on a GPU: what FramePass of the trainer does between the posed triangles and the gradients of
// splats and posed vertices. The kernels are in shaders/training, their order in gpu_steps.cpp.
//
// One thread at a time. The same device gives the same bytes for the same input: no sum depends on which lane comes first.
#pragma once

#include <memory>

#include "reconstruction/training/gpu/gpu_buffers.h"
#include "reconstruction/training/trainer/backward_mesh.h"
#include "reconstruction/training/trainer/losses.h"
#include "reconstruction/training/trainer/trainable.h"
#include "sdk/backend/vulkan/vk_open.h"
#include "sdk/math/camera.h"

namespace dpl {

/** One picture. Everything is borrowed for the call. */
struct GpuPassInput {
    const TrainableSplats& splats;                // linear values are those of its rows
    std::span<const TriangleFrame<float>> frames;  // one a triangle, world
    TrianglesAtRest rest;
    const VertexIncidence& incidence;
    const Cameraf& camera;  // of the target
    float kappaPx2 = 0;
    PictureTarget target;
    LossWeights weights;
    Vec3f background{0};
};

/** What a pass leaves. Spans are valid until the next run(). */
struct GpuPassResult {
    LossValues loss;
    std::span<const float> rowGradients;  // N × stride; rows of inactive splats hold anything
    std::span<const float> screenLength;  // N: |∂loss/∂(centre on the screen)|, per pixel; negative: no pixel shows the splat
    std::span<const Vec4f> vertices;      // V: ∂loss/∂(posed vertex), and in w ∂loss/∂(its brightness)
    uint32_t entries = 0;                 // of all tiles
};

class GpuPass {
public:
    /** A device of its own. Unsupported: no Vulkan, no device that fits the request, or one that binds too few buffers to a kernel. */
    static Result<std::unique_ptr<GpuPass>> create(const vk::DeviceRequest& request);
    ~GpuPass();

    const DeviceInfo& device() const;
    /** Graphics memory of the largest picture so far. */
    uint64_t residentBytes() const;

    /** Grows its buffers where the input is larger than before. OutOfMemory, Device: the device failed; the state is as before the call.
     *  InvalidArgument: sizes do not fit each other, or the picture has more than 65,536 tiles. */
    Result<GpuPassResult> run(const GpuPassInput& input);

private:
    explicit GpuPass(std::unique_ptr<Backend> backend);
    Status prepare(const GpuSizes& needed);
    void upload(const GpuPassInput& input) const;
    GpuPassResult read(const GpuPassInput& input, uint32_t entries);

    std::unique_ptr<Backend> backend_;
    std::unique_ptr<GpuBuffers> buffers_;
};

}  // namespace dpl
