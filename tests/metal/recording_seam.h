// SPDX-License-Identifier: Apache-2.0
// A Metal device that draws nothing: it writes down the calls, counts what is alive, and runs or fails command buffers when a test says
// so. For what the backend does on the CPU. The software device (software/) runs shaders.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "sdk/backend/metal/mtl_seam.h"

namespace dpl::mtl {

class RecordingSeam final : public Seam {
public:
    /** What outlives the seam, which the backend owns. */
    struct Record {
        std::vector<std::string> calls;  // of command buffers and encoders, in order
        int alive = 0;                   // objects that were made and not released
        bool runsAtOnce = true;          // commit() runs the command buffer; otherwise a test calls run() or fail()
        bool apple4 = true, apple5 = true;
        std::vector<void*> committed;

        size_t count(const std::string& start) const {
            size_t n = 0;
            for (const std::string& call : calls) n += call.rfind(start, 0) == 0;
            return n;
        }
    };
    struct Object {
        std::string name;
        int references = 1;
        std::vector<std::byte> bytes;
        TextureFacts facts;
        CommandStatus status = CommandStatus::NotEnqueued;
        CommandError error = CommandError::None;
        std::vector<std::pair<Object*, uint64_t>> signals;  // of a command buffer
        uint64_t value = 0;                                 // of an event
    };

    explicit RecordingSeam(Record& record) : record_(record) {}

    /** The command buffer has run. */
    static void run(void* commands) {
        Object& c = *static_cast<Object*>(commands);
        c.status = CommandStatus::Completed;
        for (auto& [event, value] : c.signals) event->value = value;
    }
    static void failWith(void* commands, CommandError error) {
        static_cast<Object*>(commands)->status = CommandStatus::Error;
        static_cast<Object*>(commands)->error = error;
    }
    static int referencesOf(void* object) { return static_cast<Object*>(object)->references; }

    std::string name() const override { return "recorder"; }
    std::string systemVersion() const override { return "1"; }
    bool isSoftware() const override { return true; }
    bool isMacText() const override { return false; }
    bool supportsFamily(GpuFamily family) const override {
        return family == GpuFamily::Apple4 ? record_.apple4 : family == GpuFamily::Apple5 ? record_.apple5 : false;
    }
    bool supportsSampleCount(uint32_t samples) const override { return samples == 1 || samples == 4; }
    bool supports32BitMsaa() const override { return true; }
    bool hasUnifiedMemory() const override { return true; }
    uint64_t maxBufferBytes() const override { return 1u << 28; }
    uint64_t workingSetBytes() const override { return 1u << 30; }

    using Seam::release;
    void release(void* object) override {
        auto* o = static_cast<Object*>(object);
        if (!o || --o->references > 0) return;
        --record_.alive;
        delete o;
    }
    void retain(void* object) override { ++static_cast<Object*>(object)->references; }
    BufferRef newBuffer(uint64_t bytes, StorageMode, std::string_view label) override {
        Object* o = make(std::string(label));
        o->bytes.resize(bytes);
        return {o};
    }
    std::byte* contents(BufferRef buffer) override { return of(buffer).bytes.data(); }
    uint64_t allocatedBytes(BufferRef buffer) override { return of(buffer).bytes.size(); }
    TextureRef newTexture(const TextureDesc& desc, std::string_view label) override {
        Object* o = make(std::string(label));
        o->facts = {desc.type, desc.format, desc.widthPx, desc.heightPx, desc.layers, desc.samples, desc.storage, desc.usage};
        return {o};
    }
    uint64_t allocatedBytes(TextureRef) override { return 0; }
    TextureFacts factsOf(TextureRef texture) override { return of(texture).facts; }
    FenceRef newFence() override { return {make(fences_++ == 0 ? "written" : "composed " + std::to_string(fences_ - 2))}; }
    EventRef newSharedEvent() override { return {make("event")}; }
    uint64_t signaledValue(EventRef event) override { return of(event).value; }
    LabelRef newLabel(std::string_view text) override { return {make(std::string(text))}; }
    LibraryRef newLibrary(std::string_view, std::string&) override { return {make("library")}; }
    FunctionRef newFunction(LibraryRef, std::string_view) override { return {make("function")}; }
    ComputePipelineRef newComputePipeline(FunctionRef, std::string&) override { return {make("pipeline")}; }
    uint32_t maxThreads(ComputePipelineRef) override { return 512; }
    RenderPipelineRef newRenderPipeline(const RenderPipelineDesc& desc, std::string&) override { return {make(std::string(desc.label))}; }
    DepthStencilRef newDepthStencil(CompareFunction, bool writes) override { return {make(writes ? "nearer" : "keep depth")}; }

    CommandsRef commandBuffer() override { return {make("commands")}; }
    void commit(CommandsRef commands) override {
        note("commit");
        of(commands).status = CommandStatus::Committed;
        record_.committed.push_back(commands.object);
        if (record_.runsAtOnce) run(commands.object);
    }
    void wait(CommandsRef commands) override {
        note("wait");
        if (of(commands).status == CommandStatus::Committed) run(commands.object);
    }
    CommandStatus status(CommandsRef commands) override { return of(commands).status; }
    CommandError error(CommandsRef commands, std::string& text) override {
        text = "planted";
        return of(commands).error;
    }
    double gpuStartS(CommandsRef) override { return 1; }
    double gpuEndS(CommandsRef) override { return 1.25; }
    void encodeWait(CommandsRef, EventRef, uint64_t value) override { note("encodeWait " + std::to_string(value)); }
    void encodeSignal(CommandsRef commands, EventRef event, uint64_t value) override {
        note("encodeSignal");
        of(commands).signals.push_back({&of(event), value});
    }
    void present(CommandsRef, DrawableRef) override { note("present"); }
    ComputeEncoderRef computeEncoder(CommandsRef) override { return {open("compute")}; }
    BlitEncoderRef blitEncoder(CommandsRef) override { return {open("blit")}; }
    RenderEncoderRef renderEncoder(CommandsRef, const RenderPassDesc& desc) override {
        return {open("render layers " + std::to_string(desc.layers) + " slice " + std::to_string(desc.colours[0].slice) + " of " +
                     of(desc.colours[0].texture).name)};
    }
    void end(ComputeEncoderRef) override { note("end compute"); }
    void end(BlitEncoderRef) override { note("end blit"); }
    void end(RenderEncoderRef) override { note("end render"); }
    void waitFence(ComputeEncoderRef, FenceRef fence) override { note("wait fence " + of(fence).name); }
    void waitFence(BlitEncoderRef, FenceRef fence) override { note("wait fence " + of(fence).name); }
    void waitFence(RenderEncoderRef, FenceRef fence, uint32_t stages) override {
        note("wait fence " + of(fence).name + " before " + std::to_string(stages));
    }
    void updateFence(ComputeEncoderRef, FenceRef fence) override { note("update fence " + of(fence).name); }
    void updateFence(BlitEncoderRef, FenceRef fence) override { note("update fence " + of(fence).name); }
    void updateFence(RenderEncoderRef, FenceRef fence, uint32_t stages) override {
        note("update fence " + of(fence).name + " after " + std::to_string(stages));
    }
    void pushLabel(ComputeEncoderRef, LabelRef label) override { note("label " + of(label).name); }
    void pushLabel(RenderEncoderRef, LabelRef label) override { note("label " + of(label).name); }
    void popLabel(ComputeEncoderRef) override {}
    void popLabel(RenderEncoderRef) override {}
    void setPipeline(ComputeEncoderRef, ComputePipelineRef) override {}
    void setBuffer(ComputeEncoderRef, BufferRef buffer, uint64_t, uint32_t index) override { note("buffer " + at(index, buffer)); }
    void setBytes(ComputeEncoderRef, const void* bytes, size_t size, uint32_t index) override { noteBytes("bytes ", bytes, size, index); }
    void setTexture(ComputeEncoderRef, TextureRef texture, uint32_t index) override { note("texture " + at(index, texture)); }
    void dispatch(ComputeEncoderRef, Size groups, Size threads) override { note("dispatch " + text(groups) + " x " + text(threads)); }
    void dispatchIndirect(ComputeEncoderRef, BufferRef args, uint64_t offset, Size threads) override {
        note("dispatch by " + of(args).name + " + " + std::to_string(offset) + " x " + text(threads));
    }
    void barrier(ComputeEncoderRef) override { note("barrier"); }
    void copyBuffer(BlitEncoderRef, BufferRef from, uint64_t fromOffset, BufferRef to, uint64_t toOffset, uint64_t bytes) override {
        note("copy " + of(from).name + " to " + of(to).name);
        ASSERT_LE(fromOffset + bytes, of(from).bytes.size());
        ASSERT_LE(toOffset + bytes, of(to).bytes.size());
        std::memcpy(of(to).bytes.data() + toOffset, of(from).bytes.data() + fromOffset, bytes);
    }
    void copyTexture(BlitEncoderRef, TextureRef from, uint32_t slice, uint32_t, uint32_t, BufferRef, uint64_t, uint32_t) override {
        note("copy texture " + of(from).name + " slice " + std::to_string(slice));
    }
    void setPipeline(RenderEncoderRef, RenderPipelineRef pipeline) override { note("pipeline " + of(pipeline).name); }
    void setVertexBuffer(RenderEncoderRef, BufferRef buffer, uint64_t, uint32_t index) override {
        note("vertex buffer " + at(index, buffer));
    }
    void setVertexBytes(RenderEncoderRef, const void* bytes, size_t size, uint32_t index) override {
        noteBytes("vertex bytes ", bytes, size, index);
    }
    void setFragmentBuffer(RenderEncoderRef, BufferRef buffer, uint64_t, uint32_t index) override {
        note("fragment buffer " + at(index, buffer));
    }
    void setFragmentBytes(RenderEncoderRef, const void* bytes, size_t size, uint32_t index) override {
        noteBytes("fragment bytes ", bytes, size, index);
    }
    void setFragmentTexture(RenderEncoderRef, TextureRef texture, uint32_t index) override {
        note("fragment texture " + at(index, texture));
    }
    void setViewport(RenderEncoderRef, double x, double y, double w, double h) override {
        note("viewport " + std::to_string(int(x)) + " " + std::to_string(int(y)) + " " + std::to_string(int(w)) + " " +
             std::to_string(int(h)));
    }
    void setDepthStencil(RenderEncoderRef, DepthStencilRef state) override { note("depth stencil " + of(state).name); }
    void setCullNone(RenderEncoderRef) override {}
    void setFill(RenderEncoderRef) override {}
    void setNoDepthBias(RenderEncoderRef) override {}
    void setOneAmplification(RenderEncoderRef) override { note("one amplification"); }
    void draw(RenderEncoderRef, PrimitiveType, uint32_t vertices, uint32_t instances) override {
        note("draw " + std::to_string(vertices) + " x " + std::to_string(instances));
    }
    void drawIndirect(RenderEncoderRef, PrimitiveType, BufferRef args, uint64_t offset) override {
        note("draw by " + of(args).name + " + " + std::to_string(offset));
    }

private:
    Object* make(std::string name) {
        ++record_.alive;
        return new Object{.name = std::move(name)};
    }
    Object* open(std::string name) {
        note(name);
        return make(std::move(name));
    }
    template <class Tag>
    static Object& of(Ref<Tag> ref) {
        return *static_cast<Object*>(ref.object);
    }
    template <class Tag>
    static std::string at(uint32_t index, Ref<Tag> ref) {
        return std::to_string(index) + " = " + of(ref).name;
    }
    static std::string text(Size s) { return std::to_string(s.x) + "," + std::to_string(s.y) + "," + std::to_string(s.z); }
    void note(std::string call) { record_.calls.push_back(std::move(call)); }
    /** The first two words too. */
    void noteBytes(const char* what, const void* bytes, size_t size, uint32_t index) {
        uint32_t words[2] = {};
        std::memcpy(words, bytes, std::min(size, sizeof words));
        note(what + std::to_string(index) + " (" + std::to_string(size) + ") " + std::to_string(words[0]) + " " + std::to_string(words[1]));
    }

    Record& record_;
    int fences_ = 0;
};

}  // namespace dpl::mtl
