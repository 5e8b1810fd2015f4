// SPDX-License-Identifier: Apache-2.0
// Implements backend.h with Metal, over the seam (docs/adr on Metal says how it orders commands). It begins and ends in mtl_backend.cpp.
// Buffers and targets are in mtl_resources.cpp, pipelines in mtl_pipelines.cpp, frames in mtl_frames.cpp, slots of an app and uploads
// between frames in mtl_slots.cpp, drawing in an app's pass in mtl_compose.cpp, command buffers of its own for that in mtl_submit.cpp.
#pragma once

#include <array>
#include <map>

#include "sdk/backend/metal/mtl_seam.h"
#include "sdk/backend/shader_pack.h"
#include "sdk/backend/slotted_backend.h"

namespace dpl::mtl {

constexpr uint32_t kViewMaskIndex = 24;  // buffer index of {first view, number of views} in shaders built with multiview
constexpr PixelFormat kColourFormat = PixelFormat::RGBA16Float;  // of targets
constexpr uint32_t kPushIndex = 29;                              // of push constants (kMslPushBuffer of tools/shaderpack/msl.h)

struct Buffer {
    BufferDesc desc;
    BufferRef buffer;         // none: Lent
    BufferRef lent;           // of a Lent buffer: the app's, not retained; used by the encode() that follows lend()
    uint64_t lentOffset = 0;  // bytes
    std::byte* mapped = nullptr;
    bool written = false;
    uint64_t born = 0;  // frames that were encoded before it was created
};

struct Target {
    TargetDesc desc;
    TextureRef colour, depth;                // arrays with a layer for each view
    TextureRef colourSamples, depthSamples;  // of a target with several samples a pixel. With multiview arrays; else of one view
    bool drawn = false;                      // by a frame that was created earlier
    uint64_t born = 0;
};

struct Pipeline {
    std::string key;
    const Shader* shader = nullptr;    // compute or vertex
    const Shader* fragment = nullptr;  // of draws
    ComputePipelineRef compute;
    RenderPipelineRef render;
    PrimitiveType primitive = PrimitiveType::Triangle;
};

struct RecordedStep {
    Step step;
    bool barrier = false;  // before it
    LabelRef label;
};

struct Frame {
    FrameRun run = FrameRun::Submitted;
    std::vector<RecordedStep> steps;
    CommandsRef commands;  // of a submitted frame that runs
    bool running = false;
    uint32_t slot = 0;  // of the app, of an encoded frame that runs
    double ms = 0;      // of the last finished run of a submitted frame; 0: none
    uint64_t born = 0;
};

/** The pass of an app in which pictures are composed. */
struct AppPass {
    PixelFormat colour = PixelFormat::None, depth = PixelFormat::None, stencil = PixelFormat::None;
    uint32_t samples = 1;
    uint32_t layers = 0;                        // 0: each view is composed by itself
    PictureDepth written = PictureDepth::None;  // by composeDepth()
};

/** The depth texture of an app behind one view. */
struct SceneTexture {
    TextureRef texture;
    ScenePlace place;  // layer: the slice
};

/** What a submission draws over, waits for and signals. Events and the drawable may be none. */
struct AppSubmission {
    std::array<TextureRef, gpu::kMaxViews> textures;  // one for each view, or one array for all
    uint32_t textureCount = 0;
    PicturePlace place;  // in the textures
    EventRef waitEvent, signalEvent;
    uint64_t waitValue = 0, signalValue = 0;
    DrawableRef drawable;
};

class MetalBackend final : public SlottedBackend {
public:
    MetalBackend(std::unique_ptr<Seam> seam, ShaderPack pack, bool lent);
    ~MetalBackend() override;
    Status start();

    const DeviceInfo& info() const override { return info_; }
    bool lost() const override { return lost_; }
    Result<BufferId> createBuffer(const BufferDesc& desc) override;
    void destroyBuffer(BufferId buffer) override;
    Status write(BufferId buffer, uint64_t offset, std::span<const std::byte> bytes) override;
    std::span<std::byte> mapped(BufferId buffer) override;
    Result<PipelineId> computePipeline(std::string_view shader) override;
    Result<PipelineId> drawPipeline(const DrawPipelineDesc& desc) override;
    uint32_t workgroupSize(PipelineId id) const override { return shader(id) ? shader(id)->workgroup[0] : 0; }
    Result<TargetId> createTarget(const TargetDesc& desc) override;
    void destroyTarget(TargetId target) override;
    Result<FrameId> createFrame(std::vector<Step> steps, FrameRun run) override;
    void destroyFrame(FrameId frame) override;
    Status submit(FrameId frame) override;
    bool finished(FrameId frame) override;
    Status wait(FrameId frame) override;
    std::vector<PassTime> passTimes(FrameId frame) override;
    double frameMs(FrameId frame) override;
    uint64_t residentBytes() const override;
    Status encode(FrameId frame, uint32_t slot, AppCommands commands) override;

    // mtl_compose.cpp: for apps that lend their device.
    Result<ComposerId> createComposer(const AppPass& pass);
    /** Whether readScene() can read the texture of a view. */
    Status checkScene(uint32_t view, const SceneTexture& from) const;
    /** To be called before encode() of the frame. Allocates and waits for nothing. */
    Status readScene(const SceneRead& read, const SceneTexture& from);

    // mtl_slots.cpp
    /** Binds an app's buffer from `offset` on in place of a Lent buffer. To be called before encode() of a frame that uses it. Allocates
     * and waits for nothing. */
    Status lend(BufferId lent, BufferRef buffer, uint64_t offset);

    // mtl_submit.cpp
    /** A new command buffer for a slot that was taken. viewCount: of the frame to encode. */
    Result<AppCommands> beginSubmission(ComposerId composer, uint32_t slot, uint32_t viewCount, const AppSubmission& how);
    /** Composes the slot into the textures, and commits. To be called after setLayers(). After an error nothing was committed. */
    Status submitTo(ComposerId composer, uint32_t slot, const AppSubmission& how);

private:
    // ResourceView
    const BufferDesc* buffer(BufferId id) const override;
    const TargetDesc* target(TargetId id) const override;
    const Shader* shader(PipelineId id) const override;
    const Shader* fragment(PipelineId id) const override;
    bool written(BufferId id) const override;
    bool drawn(TargetId id) const override;

    // mtl_resources.cpp
    Status makeBuffer(Buffer& buffer);
    Status makeTarget(Target& target);
    Result<TextureRef> makeTexture(const Target& target, PixelFormat format, bool samples, std::string_view label);
    void freeTarget(Target& target);
    PixelFormat depthSums() const { return info_.halfDepth ? PixelFormat::RG16Float : PixelFormat::RG32Float; }

    // mtl_pipelines.cpp
    Result<FunctionRef> function(const Shader& shader);
    Status makeCompute(Pipeline& pipeline);
    Status makeDraw(Pipeline& pipeline, const DrawPipelineDesc& desc);
    Result<RenderPipelineRef> renderPipeline(RenderPipelineDesc desc, const Shader& vertex, const Shader& fragment);
    PipelineId findPipeline(std::string_view key) const;
    const Pipeline& at(PipelineId id) const { return pipelines_[id.value - 1]; }

    // mtl_frames.cpp
    /** The open encoder of a command buffer. Ends it when it goes. */
    class Recorder {
    public:
        Recorder(MetalBackend& backend, CommandsRef commands) : backend_(backend), seam_(*backend.seam_), commands_(commands) {}
        ~Recorder() { close(); }
        Recorder(const Recorder&) = delete;
        Recorder& operator=(const Recorder&) = delete;
        /** An encoder of the kind: the open one, or a new one. Device: Metal gives none. */
        Result<ComputeEncoderRef> compute();
        Result<BlitEncoderRef> blit();
        void close();
        Status play(const RecordedStep& step);

    private:
        Status play(const FillStep& step);
        Status play(const ComputeStep& step);
        Status play(const DrawStep& step);
        Status play(const ReadbackStep& step);
        Status play(const CopyStep& step);
        /** Orders a new encoder behind all that must have run before it. Stages: of a render encoder. */
        template <class Encoder, class... Stages>
        void waitFor(Encoder encoder, Stages... stages) {
            seam_.waitFence(encoder, backend_.written_, stages...);
            if (first_)
                for (const FenceRef fence : backend_.composed_) seam_.waitFence(encoder, fence, stages...);
            first_ = false;
        }
        PassAttachment attachment(const Target& target, uint32_t view, TextureRef drawn, TextureRef samples) const;

        MetalBackend& backend_;
        Seam& seam_;
        CommandsRef commands_;
        ComputeEncoderRef compute_;
        BlitEncoderRef blit_;
        bool first_ = true;     // no encoder was opened yet
        LabelRef label_;        // of the step
        bool barrier_ = false;  // the step needs what steps before it wrote; a new encoder waits for them anyway
    };
    Status play(const Frame& frame, CommandsRef commands);
    Result<CommandsRef> newCommands();
    Status endOf(CommandsRef commands);
    Status waitFor(Frame& frame);
    Status commitAndWait(CommandsRef commands);
    void ended(Frame& frame);
    void freeFrame(Frame& frame);

    // mtl_slots.cpp
    bool lent() const override { return lent_; }
    void writeMark(uint32_t slot, uint64_t mark, AppCommands commands) override;
    Result<bool> slotEnded(uint32_t slot, uint64_t mark) override;
    bool slotHasRun(uint32_t slot, uint64_t mark) const override;
    void slotIsFree(uint32_t slot, bool ran) override;
    void freeRetired(uint64_t oldest) override;
    Status encodeCopy(const CopyQueue::Copy& copy, AppCommands commands) override;
    Status encodeCopy(CommandsRef commands, BufferRef from, uint64_t fromOffset, BufferRef to, uint64_t toOffset, uint64_t bytes);
    void setWritten(BufferId id) override { buffers_.at(id.value).written = true; }
    Status submitCopy(const CopyQueue::Copy& copy) override;
    Result<bool> submittedCopyHasRun(CopyQueue::Copy& copy) override;
    void waitForCopy() override;
    template <class Tag>
    void retire(Ref<Tag>& object, uint64_t born) {
        if (object) retired_.retire(object.object, born, encoded(), [&](void* unneeded) { seam_->release(unneeded); });
        object = {};
    }

    // mtl_compose.cpp
    struct Composer {
        AppPass pass;
        RenderPipelineRef pipeline, depthPipeline;
    };
    struct Layer {  // of a view; what setLayers() said
        TextureRef drawn, sums;
        BufferRef tiled, mesh;
    };
    struct Unread {  // what is bound in place of what a picture lacks
        TargetId target;
        BufferId buffer;
    };
    Result<Unread> makeUnread();
    bool viewsShareImage(const TargetDesc&) const override { return true; }
    void setLayer(uint32_t slot, uint32_t view, const LayerPlace& place) override;
    Status drawPicture(const PictureDraw& what, PassCommands pass) override;
    void retireComposer(ComposerId composer) override;
    Status makeComposing();
    Result<bool> blendsLight(const AppPass& pass) const;
    Status makePipelines(Composer& composer);
    Result<FenceRef> nextFence();

    std::unique_ptr<Seam> seam_;
    ShaderPack pack_;
    DeviceInfo info_;
    const bool lent_;  // the device and the queue are an app's
    bool lost_ = false;
    bool memoryless_ = false;  // targets of several samples need no memory
    // Each encoder of ours waits for `written_` and updates it, so they run one after the other. compose() makes the app's encoder wait for
    // `written_` and update a fence of its own among `composed_`; the first encoder of what we encode next waits for all of these. A fence
    // each, because a fence stands for its last update, and an encoder must not wait for a fence that it has updated.
    FenceRef written_;
    std::vector<FenceRef> composed_;
    size_t composes_ = 0;  // since a slot was taken
    PipelineId fill_, round_;
    std::map<uint32_t, Buffer> buffers_;
    std::map<uint32_t, Target> targets_;
    std::map<uint32_t, Frame> frames_;
    std::vector<Pipeline> pipelines_;  // PipelineId::value is the index + 1
    CommandsRef copyCommands_;         // of the copy that is committed; on a device of the backend's own

    // Of encoded frames.
    RetiredObjects<void*> retired_;
    EventRef marks_;                                     // signalled behind the commands of each slot
    std::array<CommandsRef, kAppSlots> slotCommands_{};  // that were encoded last with the slot, retained to see whether they failed
    std::map<uint32_t, Composer> composers_;
    PipelineId readScene_[2][2];                                       // [without layers][four samples]
    DepthStencilRef keepDepth_, nearer_[2];                            // compose(); composeDepth() where less is nearer, where greater is
    std::array<std::array<Layer, gpu::kMaxViews>, kAppSlots> layers_;  // by slot and view
    Unread unread_;
    std::array<CommandsRef, kAppSlots> submissions_{};  // begun and not committed
};

/** On an app's id<MTLDevice> and id<MTLCommandQueue>. Errors as lendSeam() and createMetalBackend(). */
Result<std::unique_ptr<MetalBackend>> createBackendOn(void* device, void* queue);
/** On a seam. `lent`: slots and composers work, as on a device of an app. */
Result<std::unique_ptr<MetalBackend>> createBackendOn(std::unique_ptr<Seam> seam, bool lent);
/** With kernels other than the SDK's. `fill` and `round` must be among them. */
Result<std::unique_ptr<MetalBackend>> createBackendOn(std::unique_ptr<Seam> seam, bool lent, ShaderPack pack);

}  // namespace dpl::mtl
