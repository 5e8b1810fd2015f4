// SPDX-License-Identifier: Apache-2.0
#include "tests/metal/software/idle_seam.h"

#include <algorithm>
#include <vector>

namespace dpl::mtl {
namespace {

/** Buffers and textures. All other handles are kAny, which nobody frees. */
struct Resource {
    std::vector<std::byte> bytes;
    TextureFacts facts;
    uint32_t references = 1;
};
Resource kAny;

class IdleSeam final : public Seam {
public:
    std::string name() const override { return "idle Metal device"; }
    std::string systemVersion() const override { return "tests"; }
    bool isSoftware() const override { return true; }
    bool isMacText() const override { return false; }
    bool supportsFamily(GpuFamily family) const override { return family == GpuFamily::Apple4 || family == GpuFamily::Apple5; }
    bool supportsSampleCount(uint32_t samples) const override { return samples == 1 || samples == 4; }
    bool supports32BitMsaa() const override { return true; }
    bool hasUnifiedMemory() const override { return true; }
    uint64_t maxBufferBytes() const override { return 256ull << 20; }
    uint64_t workingSetBytes() const override { return 1ull << 30; }

    using Seam::release;
    void release(void* object) override {
        auto* resource = static_cast<Resource*>(object);
        if (resource != &kAny && --resource->references == 0) delete resource;
    }
    void retain(void* object) override {
        if (object != &kAny) ++static_cast<Resource*>(object)->references;
    }
    BufferRef newBuffer(uint64_t bytes, StorageMode, std::string_view) override {
        return {new Resource{std::vector<std::byte>(bytes), {}}};
    }
    std::byte* contents(BufferRef buffer) override { return of(buffer).bytes.data(); }
    uint64_t allocatedBytes(BufferRef buffer) override { return of(buffer).bytes.size(); }
    TextureRef newTexture(const TextureDesc& d, std::string_view) override {
        return {new Resource{{}, {d.type, d.format, d.widthPx, d.heightPx, d.layers, d.samples, d.storage, d.usage}}};
    }
    uint64_t allocatedBytes(TextureRef) override { return 0; }
    TextureFacts factsOf(TextureRef texture) override { return of(texture).facts; }
    FenceRef newFence() override { return {&kAny}; }
    EventRef newSharedEvent() override { return {&kAny}; }
    uint64_t signaledValue(EventRef) override { return lastSignal_; }
    LabelRef newLabel(std::string_view) override { return {&kAny}; }
    LibraryRef newLibrary(std::string_view, std::string&) override { return {&kAny}; }
    FunctionRef newFunction(LibraryRef, std::string_view) override { return {&kAny}; }
    ComputePipelineRef newComputePipeline(FunctionRef, std::string&) override { return {&kAny}; }
    uint32_t maxThreads(ComputePipelineRef) override { return 1024; }
    RenderPipelineRef newRenderPipeline(const RenderPipelineDesc&, std::string&) override { return {&kAny}; }
    DepthStencilRef newDepthStencil(CompareFunction, bool) override { return {&kAny}; }

    CommandsRef commandBuffer() override { return {&kAny}; }
    void commit(CommandsRef) override {}
    void wait(CommandsRef) override {}
    CommandStatus status(CommandsRef) override { return CommandStatus::Completed; }
    CommandError error(CommandsRef, std::string&) override { return CommandError::None; }
    double gpuStartS(CommandsRef) override { return 0; }
    double gpuEndS(CommandsRef) override { return 0; }
    void encodeWait(CommandsRef, EventRef, uint64_t) override {}
    void encodeSignal(CommandsRef, EventRef, uint64_t value) override { lastSignal_ = std::max(lastSignal_, value); }
    void present(CommandsRef, DrawableRef) override {}
    ComputeEncoderRef computeEncoder(CommandsRef) override { return {&kAny}; }
    BlitEncoderRef blitEncoder(CommandsRef) override { return {&kAny}; }
    RenderEncoderRef renderEncoder(CommandsRef, const RenderPassDesc&) override { return {&kAny}; }
    void end(ComputeEncoderRef) override {}
    void end(BlitEncoderRef) override {}
    void end(RenderEncoderRef) override {}
    void waitFence(ComputeEncoderRef, FenceRef) override {}
    void waitFence(BlitEncoderRef, FenceRef) override {}
    void waitFence(RenderEncoderRef, FenceRef, uint32_t) override {}
    void updateFence(ComputeEncoderRef, FenceRef) override {}
    void updateFence(BlitEncoderRef, FenceRef) override {}
    void updateFence(RenderEncoderRef, FenceRef, uint32_t) override {}
    void pushLabel(ComputeEncoderRef, LabelRef) override {}
    void pushLabel(RenderEncoderRef, LabelRef) override {}
    void popLabel(ComputeEncoderRef) override {}
    void popLabel(RenderEncoderRef) override {}
    void setPipeline(ComputeEncoderRef, ComputePipelineRef) override {}
    void setBuffer(ComputeEncoderRef, BufferRef, uint64_t, uint32_t) override {}
    void setBytes(ComputeEncoderRef, const void*, size_t, uint32_t) override {}
    void setTexture(ComputeEncoderRef, TextureRef, uint32_t) override {}
    void dispatch(ComputeEncoderRef, Size, Size) override {}
    void dispatchIndirect(ComputeEncoderRef, BufferRef, uint64_t, Size) override {}
    void barrier(ComputeEncoderRef) override {}
    void copyBuffer(BlitEncoderRef, BufferRef, uint64_t, BufferRef, uint64_t, uint64_t) override {}
    void copyTexture(BlitEncoderRef, TextureRef, uint32_t, uint32_t, uint32_t, BufferRef, uint64_t, uint32_t) override {}
    void setPipeline(RenderEncoderRef, RenderPipelineRef) override {}
    void setVertexBuffer(RenderEncoderRef, BufferRef, uint64_t, uint32_t) override {}
    void setVertexBytes(RenderEncoderRef, const void*, size_t, uint32_t) override {}
    void setFragmentBuffer(RenderEncoderRef, BufferRef, uint64_t, uint32_t) override {}
    void setFragmentBytes(RenderEncoderRef, const void*, size_t, uint32_t) override {}
    void setFragmentTexture(RenderEncoderRef, TextureRef, uint32_t) override {}
    void setViewport(RenderEncoderRef, double, double, double, double) override {}
    void setDepthStencil(RenderEncoderRef, DepthStencilRef) override {}
    void setCullNone(RenderEncoderRef) override {}
    void setFill(RenderEncoderRef) override {}
    void setNoDepthBias(RenderEncoderRef) override {}
    void setOneAmplification(RenderEncoderRef) override {}
    void draw(RenderEncoderRef, PrimitiveType, uint32_t, uint32_t) override {}
    void drawIndirect(RenderEncoderRef, PrimitiveType, BufferRef, uint64_t) override {}

private:
    template <class Tag>
    static Resource& of(Ref<Tag> ref) {
        return *static_cast<Resource*>(ref.object);
    }
    uint64_t lastSignal_ = 0;  // of all events
};

}  // namespace

std::unique_ptr<Seam> idleSeam() {
    return std::make_unique<IdleSeam>();
}

}  // namespace dpl::mtl
