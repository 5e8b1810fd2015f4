// SPDX-License-Identifier: Apache-2.0
// Implements backend.h with Vulkan. It begins and ends in vk_backend.cpp. Buffers and targets are in vk_resources.cpp, pipelines in
// vk_pipelines.cpp, frames in vk_frames.cpp, slots of an app and uploads between frames in vk_slots.cpp, drawing in an app's pass in
// vk_compose.cpp, submissions for it in vk_submit.cpp.
#pragma once

#include <array>
#include <map>
#include <tuple>
#include <variant>

#include "sdk/backend/shader_pack.h"
#include "sdk/backend/slotted_backend.h"
#include "sdk/backend/vulkan/vk_device.h"

namespace dpl::vk {

struct Buffer {
    BufferDesc desc;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    std::byte* mapped = nullptr;
    VkBufferView texels[3] = {};  // for texels of 1, 2 and 4 words; made when a frame first reads the buffer so
    uint64_t allocatedBytes = 0;
    bool written = false;
    uint64_t born = 0;  // frames that were encoded before it was created
};

struct Image {
    VkImage image = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;  // all layers; null for images that are only copied
    uint64_t allocatedBytes = 0;
};

/** The images that one draw fills. */
struct Surface {
    Image colour, depth;
    Image rounded;                      // RGBA8 copy of a target with more than 8 bits
    Image colourSamples, depthSamples;  // of a target with several samples a pixel; tile-based GPUs keep them on the chip
    VkFramebuffer framebuffer = VK_NULL_HANDLE;
};

struct Target {
    TargetDesc desc;
    VkExtent2D extent{};
    // With multiview: one surface that has a layer for each view. Without: one surface for each view, because lavapipe 22.3.6 resolves
    // the samples of layer 0 into layer 0, whichever layer is drawn.
    std::vector<Surface> surfaces;
    bool drawn = false;  // by a frame that was created earlier
    uint64_t born = 0;   // frames that were encoded before it was created
};

inline VkDescriptorType descriptorType(const ShaderBinding& b) {
    return b.uniform      ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER
           : b.image      ? VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE
           : b.texelWords ? VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER
                          : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

struct Pipeline {
    std::string key;
    const Shader* shader = nullptr;    // compute or vertex
    const Shader* fragment = nullptr;  // of draws
    VkDescriptorSetLayout setLayout = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
    VkShaderStageFlags stages = 0;  // stages that read the push constants
};

/** A step with what was prepared for it when its frame was created. */
struct RecordedStep {
    Step step;
    bool barrier = false;                          // before it
    VkDescriptorSet descriptors = VK_NULL_HANDLE;  // of compute and draw steps
};

struct Frame {
    FrameRun run = FrameRun::Submitted;
    std::vector<RecordedStep> steps;  // of an encoded frame
    VkDescriptorPool descriptors = VK_NULL_HANDLE;
    // The pool, the command buffer and the fence belong to submitted frames.
    VkCommandPool commands = VK_NULL_HANDLE;
    VkCommandBuffer commandBuffer = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
    bool running = false;             // submitted, and its fence was not seen to be signalled yet
    uint32_t slot = 0;                // of the app, of an encoded frame that runs
    std::vector<std::string> labels;  // of the steps
    // Timestamps before the first step and after each step. Reading them costs more than encoding, so an encoded frame has two pools: one
    // keeps the last finished run until somebody asks for its times, the other takes the next run.
    std::array<VkQueryPool, 2> timestamps{};
    uint32_t nextTimestamps = 0;          // index of the pool that the next run writes
    VkQueryPool unread = VK_NULL_HANDLE;  // pool of the last finished run, if it was not read into `ticks` yet
    std::vector<uint64_t> ticks;
    bool timed = false;  // ticks hold a finished run
    uint64_t born = 0;   // frames that were encoded before it was created
};

/** The pass of an app in which its target is composed. */
struct AppPass {
    VkRenderPass renderPass = VK_NULL_HANDLE;  // or one that is compatible with it; null: dynamic rendering
    uint32_t subpass = 0;
    uint32_t samples = 1;
    uint32_t viewMask = 0;  // 0: no multiview
    VkFormat colour = VK_FORMAT_UNDEFINED;
    VkFormat depth = VK_FORMAT_UNDEFINED, stencil = VK_FORMAT_UNDEFINED;  // attachments that the pass has; only for dynamic rendering
    PictureDepth written = PictureDepth::None;                            // by composeDepth()
};

/** Images of an app that submitTo() draws into: one for each view, or a 2D array with the pass's view mask. */
struct AppTargetDesc {
    AppPass pass;  // without a render pass, which is made
    VkImageView images[gpu::kMaxViews] = {};
    uint32_t imageCount = 0;
    VkExtent2D extent{};
    VkImageLayout before = VK_IMAGE_LAYOUT_UNDEFINED, after = VK_IMAGE_LAYOUT_UNDEFINED;
};
struct AppTarget {
    AppTargetDesc desc;
    VkRenderPass pass = VK_NULL_HANDLE;
    VkFramebuffer framebuffers[gpu::kMaxViews] = {};
    ComposerId composer;
};
using AppTargetId = GpuId<struct AppTargetTag>;

/** What a submission waits for and signals. Values: of timeline semaphores, as many as semaphores, or none. */
struct AppSubmission {
    std::span<const VkSemaphore> waits, signals;
    std::span<const VkPipelineStageFlags> waitStages;  // as many as waits
    std::span<const uint64_t> waitValues, signalValues;
    VkFence fence = VK_NULL_HANDLE;
};

/** An object that commands of an app may need after it was destroyed. */
using Retirable = std::variant<Buffer, Target, Frame, VkPipeline, AppTarget>;

/** The depth image of an app behind one view. */
struct SceneImage {
    VkImageView view = VK_NULL_HANDLE;  // of the depth aspect, 2D array
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    uint32_t samples = 1;
    ScenePlace place;
};

/** Of targets. Every Vulkan device blends it. */
constexpr VkFormat kColourFormat = VK_FORMAT_R16G16B16A16_SFLOAT;

class VulkanBackend final : public SlottedBackend {
public:
    VulkanBackend(std::unique_ptr<Device> device, ShaderPack pack);
    ~VulkanBackend() override;
    Status start();

    const DeviceInfo& info() const override { return device_->info; }
    bool lost() const override { return device_->lost; }
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

    // vk_compose.cpp: for apps that lend their device.
    Result<ComposerId> createComposer(const AppPass& pass);
    /** To be called before encode() of the frame. Allocates and waits for nothing. */
    Status readScene(const SceneRead& read, const SceneImage& image);

    // vk_slots.cpp
    /** Binds bytes of an app's buffer in place of a Lent buffer, in an encoded frame whose last run has finished. To be called before
     *  encode() of the frame. offset: a multiple of 256. Allocates and waits for nothing. */
    Status lend(FrameId frame, BufferId lent, VkBuffer buffer, uint64_t offset, uint64_t bytes);

    // vk_submit.cpp: draws with submissions of our own on the app's device.
    /** Makes the pass, framebuffers and composer of a target. Unsupported: as createComposer(). */
    Result<AppTargetId> createAppTarget(const AppTargetDesc& desc);
    /** NotFound: no such target. Submissions that use it may still run. */
    Status destroyAppTarget(AppTargetId target);
    /** The command buffer of a slot that was taken, recording. viewCount: of the frame to encode. NotFound: no such target. */
    Result<AppCommands> beginSubmission(AppTargetId target, uint32_t slot, uint32_t viewCount);
    /** Composes the slot into the target, and submits. To be called after setLayers(). After an error nothing was submitted. Waits for
     *  nothing but the app's lock of the queue. */
    Status submitTo(AppTargetId target, uint32_t slot, PicturePlace place, const AppSubmission& how);

private:
    // ResourceView
    const BufferDesc* buffer(BufferId id) const override;
    const TargetDesc* target(TargetId id) const override;
    const Shader* shader(PipelineId id) const override;
    const Shader* fragment(PipelineId id) const override;
    bool written(BufferId id) const override;
    bool drawn(TargetId id) const override;

    // vk_resources.cpp
    Result<uint32_t> memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted, VkMemoryPropertyFlags preferred) const;
    Status makeBuffer(Buffer& buffer);
    void freeBuffer(Buffer& buffer);
    Result<VkBufferView> texels(Buffer& buffer, uint32_t words);
    Status makeImage(Image& image, VkFormat format, const Target& target, VkImageUsageFlags usage, uint32_t samples = 1);
    Status makeSurface(Surface& surface, const Target& target);
    void freeSurface(Surface& surface);
    void freeImage(Image& image);
    Status makeTarget(Target& target);
    void freeTarget(Target& target);

    // vk_pipelines.cpp
    Result<VkRenderPass> renderPass(const TargetDesc& target);
    Result<VkShaderModule> shaderModule(const Shader& shader);
    Status makeLayouts(Pipeline& pipeline);
    Status makeCompute(Pipeline& pipeline);
    Status makeDraw(Pipeline& pipeline, const DrawPipelineDesc& desc);
    void freePipeline(Pipeline& pipeline);
    const Shader* findShader(std::string_view name) const;  // the kernel with typed buffers if the device wants it and the pack has it
    PipelineId findPipeline(std::string_view key) const;

    // vk_frames.cpp
    Status makeDescriptorPool(Frame& frame, std::span<const Step> steps);
    Result<VkDescriptorSet> descriptorSet(const Frame& frame, const Pipeline& pipeline, const std::vector<Binding>& bindings);
    Status prepare(Frame& frame, std::vector<Step> steps);
    Status record(Frame& frame);
    Status play(const Frame& frame, VkCommandBuffer commands);
    Status submitAndWait(VkCommandBuffer commands);
    Status waitFor(Frame& frame);
    Status waitFor(VkFence fence);
    Status checkPresent();
    Error failVk(std::string_view what, VkResult result);  // of DPL_VK; remembers that the device was lost
    void ended(Frame& frame);
    bool readTicks(Frame& frame, uint32_t first, uint32_t count);
    void readAllTicks(Frame& frame);
    double ticksMs(uint64_t from, uint64_t to) const;
    void freeFrame(Frame& frame);
    struct Recorder;

    // vk_slots.cpp
    bool lent() const override { return device_->lent; }
    void writeMark(uint32_t slot, uint64_t mark, AppCommands commands) override;
    Result<bool> slotEnded(uint32_t slot, uint64_t mark) override;
    bool slotHasRun(uint32_t slot, uint64_t mark) const override;
    void slotIsFree(uint32_t slot, bool ran) override;
    void freeRetired(uint64_t oldest) override;
    void barrierAfterSlot(AppCommands commands) override;
    void barrierBeforeCopies(AppCommands commands) override;
    Status encodeCopy(const CopyQueue::Copy& copy, AppCommands commands) override;
    void setWritten(BufferId id) override { buffers_.at(id.value).written = true; }
    Status submitCopy(const CopyQueue::Copy& copy) override;
    Result<bool> submittedCopyHasRun(CopyQueue::Copy& copy) override;
    void waitForCopy() override { (void)waitFor(copyFence_); }
    void retire(Retirable object, uint64_t born);
    void free(Retirable& object);

    // vk_compose.cpp
    struct Composer {
        VkPipeline pipeline = VK_NULL_HANDLE;
        VkPipeline writeDepth[2] = {};  // where less is nearer; where greater is
    };
    struct LayerSlot {                                     // what setLayers() said
        VkDescriptorSet descriptors[gpu::kMaxViews] = {};  // of each view
        VkDescriptorSet scenes[gpu::kMaxViews] = {};       // of readScene()
    };
    bool viewsShareImage(const TargetDesc& target) const override { return target.multiview; }
    void setLayer(uint32_t slot, uint32_t view, const LayerPlace& place) override;
    Status drawPicture(const PictureDraw& what, PassCommands pass) override;
    void retireComposer(ComposerId composer) override;
    struct Unread {  // what is bound in place of what a picture lacks
        TargetId target;
        BufferId buffer;
    };
    Status makeLayerSlots();
    Result<bool> blendsLight(const AppPass& pass) const;
    Result<VkDescriptorSet> layerDescriptors(VkDescriptorSetLayout layout);
    /** depth: how what is nearer compares, in a pipeline that writes depth; VK_COMPARE_OP_ALWAYS in one that writes colour. */
    Result<VkPipeline> composePipeline(const AppPass& pass, const Shader& fragment, VkCompareOp nearer);
    Status makePipelines(Composer& composer, const AppPass& pass);
    void freeComposer(Composer& composer);

    // vk_submit.cpp
    Status makeSubmissions();
    Status makeAppTarget(AppTarget& target);
    void freeAppTarget(AppTarget& target);

    std::unique_ptr<Device> device_;
    const Functions& vk_;  // of device_
    ShaderPack pack_;
    VkFence fence_ = VK_NULL_HANDLE;  // of uploads
    VkCommandPool uploadPool_ = VK_NULL_HANDLE;
    VkCommandBuffer uploadCommands_ = VK_NULL_HANDLE;
    std::map<uint32_t, Buffer> buffers_;
    std::map<uint32_t, Target> targets_;
    std::map<uint32_t, Frame> frames_;
    std::vector<Pipeline> pipelines_;                                                  // PipelineId::value is the index + 1
    std::map<std::tuple<uint32_t, bool, uint32_t, bool>, VkRenderPass> renderPasses_;  // by layers, depth, samples, sampled
    VkCommandBuffer copyCommands_ = VK_NULL_HANDLE;  // of the copy that is submitted; on a device of the backend's own
    VkFence copyFence_ = VK_NULL_HANDLE;

    // Of encoded frames.
    RetiredObjects<Retirable> retired_;
    Buffer marks_;  // a word for each slot: the GPU writes the low half of a mark there when it has come so far
    std::map<uint32_t, Composer> composers_;
    Pipeline composeLayout_;   // layouts and shaders of all composers, without a pipeline
    PipelineId readScene_[2];  // of one sample, of four
    VkDescriptorPool layerDescriptors_ = VK_NULL_HANDLE;
    Unread unread_;
    std::array<LayerSlot, kAppSlots> layerSlots_;
    std::map<uint32_t, AppTarget> appTargets_;
    VkCommandPool submissionPool_ = VK_NULL_HANDLE;
    std::array<VkCommandBuffer, kAppSlots> submissionCommands_{};
};

/** A backend on a device that an app lends. Errors as borrowDevice and createVulkanBackend. */
Result<std::unique_ptr<VulkanBackend>> createBackendOn(const AppDevice& app);

}  // namespace dpl::vk
