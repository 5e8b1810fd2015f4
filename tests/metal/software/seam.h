// SPDX-License-Identifier: Apache-2.0
// The seam over the state of a software device. Encoding checks what is known then and appends closures, which run with the commands.
#pragma once

#include "tests/metal/software/objects.h"

namespace dpl::mtl {

/** What a shader gets in one dispatch or draw. */
struct Ready {
    bool fine = true;  // false: something is missing, and the command is left out
    msl::Bindings bindings;
    struct Use {
        const Object* resource;
        uint64_t begin, end;  // bytes or slices
        bool writes;
        uint32_t index;  // of a buffer; above 30: a texture
    };
    std::vector<Use> uses;
    std::vector<std::shared_ptr<std::vector<std::byte>>> heldBytes;  // of setBytes
};

class SoftSeam final : public Seam {
public:
    explicit SoftSeam(std::shared_ptr<DeviceState> state) : state_(std::move(state)) {}

    std::string name() const override { return "software Metal device"; }
    std::string systemVersion() const override { return "tests"; }
    bool isSoftware() const override { return true; }
    bool isMacText() const override { return false; }
    bool supportsFamily(GpuFamily family) const override;
    bool supportsSampleCount(uint32_t samples) const override { return samples == 1 || (samples == 4 && state_->options.fourSamples); }
    bool supports32BitMsaa() const override { return state_->options.msaa32; }
    bool hasUnifiedMemory() const override { return true; }
    uint64_t maxBufferBytes() const override { return 256ull << 20; }
    uint64_t workingSetBytes() const override { return 8ull << 30; }

    using Seam::release;
    void release(void* object) override { state_->release(object); }
    void retain(void* object) override;
    BufferRef newBuffer(uint64_t bytes, StorageMode storage, std::string_view label) override;
    std::byte* contents(BufferRef buffer) override;
    uint64_t allocatedBytes(BufferRef buffer) override;
    TextureRef newTexture(const TextureDesc& desc, std::string_view label) override;
    uint64_t allocatedBytes(TextureRef texture) override;
    TextureFacts factsOf(TextureRef texture) override;
    FenceRef newFence() override { return {state_->add(std::make_unique<SoftFence>())}; }
    EventRef newSharedEvent() override { return {state_->add(std::make_unique<SoftEvent>())}; }
    uint64_t signaledValue(EventRef event) override;
    LabelRef newLabel(std::string_view text) override { return {state_->add(std::make_unique<SoftLabel>(text))}; }

    LibraryRef newLibrary(std::string_view msl, std::string& error) override;
    FunctionRef newFunction(LibraryRef library, std::string_view name) override;
    ComputePipelineRef newComputePipeline(FunctionRef function, std::string& error) override;
    uint32_t maxThreads(ComputePipelineRef pipeline) override;
    RenderPipelineRef newRenderPipeline(const RenderPipelineDesc& desc, std::string& error) override;
    DepthStencilRef newDepthStencil(CompareFunction nearer, bool writes) override;

    CommandsRef commandBuffer() override { return {state_->add(std::make_unique<SoftCommands>())}; }
    void commit(CommandsRef commands) override;
    void wait(CommandsRef commands) override;
    CommandStatus status(CommandsRef commands) override;
    CommandError error(CommandsRef commands, std::string& text) override;
    double gpuStartS(CommandsRef commands) override;
    double gpuEndS(CommandsRef commands) override;
    void encodeWait(CommandsRef commands, EventRef event, uint64_t value) override;
    void encodeSignal(CommandsRef commands, EventRef event, uint64_t value) override;
    void present(CommandsRef commands, DrawableRef drawable) override;

    ComputeEncoderRef computeEncoder(CommandsRef commands) override { return {newEncoder(commands, EncoderKind::Compute)}; }
    BlitEncoderRef blitEncoder(CommandsRef commands) override { return {newEncoder(commands, EncoderKind::Blit)}; }
    RenderEncoderRef renderEncoder(CommandsRef commands, const RenderPassDesc& desc) override;
    void end(ComputeEncoderRef encoder) override { endEncoder(encoder.object); }
    void end(BlitEncoderRef encoder) override { endEncoder(encoder.object); }
    void end(RenderEncoderRef encoder) override { endEncoder(encoder.object); }
    void waitFence(ComputeEncoderRef encoder, FenceRef fence) override { waitFor(encoder.object, fence, kStageVertex); }
    void waitFence(BlitEncoderRef encoder, FenceRef fence) override { waitFor(encoder.object, fence, kStageVertex); }
    void waitFence(RenderEncoderRef encoder, FenceRef fence, uint32_t stages) override { waitFor(encoder.object, fence, stages); }
    void updateFence(ComputeEncoderRef encoder, FenceRef fence) override { update(encoder.object, fence, kStageVertex); }
    void updateFence(BlitEncoderRef encoder, FenceRef fence) override { update(encoder.object, fence, kStageVertex); }
    void updateFence(RenderEncoderRef encoder, FenceRef fence, uint32_t stages) override { update(encoder.object, fence, stages); }
    void pushLabel(ComputeEncoderRef encoder, LabelRef label) override { push(encoder.object, label); }
    void pushLabel(RenderEncoderRef encoder, LabelRef label) override { push(encoder.object, label); }
    void popLabel(ComputeEncoderRef encoder) override { pop(encoder.object); }
    void popLabel(RenderEncoderRef encoder) override { pop(encoder.object); }

    void setPipeline(ComputeEncoderRef encoder, ComputePipelineRef pipeline) override;
    void setBuffer(ComputeEncoderRef encoder, BufferRef buffer, uint64_t offset, uint32_t index) override {
        bind(encoder.object, 0, buffer, offset, index);
    }
    void setBytes(ComputeEncoderRef encoder, const void* bytes, size_t size, uint32_t index) override {
        bindBytes(encoder.object, 0, bytes, size, index);
    }
    void setTexture(ComputeEncoderRef encoder, TextureRef texture, uint32_t index) override { bind(encoder.object, 0, texture, index); }
    void dispatch(ComputeEncoderRef encoder, Size groups, Size threads) override;
    void dispatchIndirect(ComputeEncoderRef encoder, BufferRef args, uint64_t offset, Size threads) override;
    void barrier(ComputeEncoderRef encoder) override;

    void copyBuffer(BlitEncoderRef encoder, BufferRef from, uint64_t fromOffset, BufferRef to, uint64_t toOffset, uint64_t bytes) override;
    void copyTexture(BlitEncoderRef encoder, TextureRef from, uint32_t slice, uint32_t widthPx, uint32_t heightPx, BufferRef to,
                     uint64_t toOffset, uint32_t bytesPerRow) override;

    void setPipeline(RenderEncoderRef encoder, RenderPipelineRef pipeline) override;
    void setVertexBuffer(RenderEncoderRef encoder, BufferRef buffer, uint64_t offset, uint32_t index) override {
        bind(encoder.object, 0, buffer, offset, index);
    }
    void setVertexBytes(RenderEncoderRef encoder, const void* bytes, size_t size, uint32_t index) override {
        bindBytes(encoder.object, 0, bytes, size, index);
    }
    void setFragmentBuffer(RenderEncoderRef encoder, BufferRef buffer, uint64_t offset, uint32_t index) override {
        bind(encoder.object, 1, buffer, offset, index);
    }
    void setFragmentBytes(RenderEncoderRef encoder, const void* bytes, size_t size, uint32_t index) override {
        bindBytes(encoder.object, 1, bytes, size, index);
    }
    void setFragmentTexture(RenderEncoderRef encoder, TextureRef texture, uint32_t index) override {
        bind(encoder.object, 1, texture, index);
    }
    void setViewport(RenderEncoderRef encoder, double x, double y, double widthPx, double heightPx) override;
    void setDepthStencil(RenderEncoderRef encoder, DepthStencilRef state) override;
    void setCullNone(RenderEncoderRef encoder) override { openEncoder(encoder.object, "setCullMode"); }
    void setFill(RenderEncoderRef encoder) override { openEncoder(encoder.object, "setTriangleFillMode"); }
    void setNoDepthBias(RenderEncoderRef encoder) override { openEncoder(encoder.object, "setDepthBias"); }
    void setOneAmplification(RenderEncoderRef encoder) override { openEncoder(encoder.object, "setVertexAmplificationCount"); }
    void draw(RenderEncoderRef encoder, PrimitiveType type, uint32_t vertices, uint32_t instances) override;
    void drawIndirect(RenderEncoderRef encoder, PrimitiveType type, BufferRef args, uint64_t offset) override;

private:
    /** A command buffer into which one may encode now; nullptr and a fault otherwise. */
    SoftCommands* openCommands(CommandsRef commands, const char* call);
    SoftEncoder* openEncoder(void* encoder, const char* call);
    SoftEncoder* newEncoder(CommandsRef commands, EncoderKind kind);
    void endEncoder(void* encoder);
    void waitFor(void* encoder, FenceRef fence, uint32_t stages);
    void update(void* encoder, FenceRef fence, uint32_t stages);
    void push(void* encoder, LabelRef label);
    void pop(void* encoder);
    void bind(void* encoder, int stage, BufferRef buffer, uint64_t offset, uint32_t index);
    void bindBytes(void* encoder, int stage, const void* bytes, size_t size, uint32_t index);
    void bind(void* encoder, int stage, TextureRef texture, uint32_t index);
    void set(SoftEncoder& encoder, int stage, uint32_t index, BoundBuffer what);
    Ready ready(SoftEncoder& encoder, int stage, const msl::Entry& entry);
    void encodeDispatch(void* encoder, Size groups, SoftBuffer* args, uint64_t offset, Size threads);
    void encodeDraw(void* encoder, PrimitiveType type, uint32_t vertices, uint32_t instances, SoftBuffer* args, uint64_t offset);
    SoftBuffer* argsAt(BufferRef args, uint64_t offset, uint64_t bytes, const char* call);
    bool checkAttachment(const PassAttachment& attachment, const RenderPassDesc& desc, bool depth);
    bool fits(const SoftEncoder& encoder);
    void beginPass(SoftCommands& commands, SoftEncoder& encoder);
    void endPass(SoftCommands& commands, SoftEncoder& encoder);
    void fault(const SoftEncoder& encoder, const std::string& text) { state_->fault(encoder.place() + ": " + text); }

    std::shared_ptr<DeviceState> state_;
};

}  // namespace dpl::mtl
