// SPDX-License-Identifier: Apache-2.0
// Implements backend.h with Vulkan. Buffers and targets are in vk_resources.cpp, pipelines in vk_pipelines.cpp, frames in vk_frames.cpp.
#pragma once

#include <map>
#include <tuple>

#include "sdk/backend/frame_check.h"
#include "sdk/backend/shader_pack.h"
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
};

inline VkDescriptorType descriptorType(const ShaderBinding& b) {
    return b.uniform      ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER
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

struct Frame {
    VkDescriptorPool descriptors = VK_NULL_HANDLE;
    VkCommandPool commands = VK_NULL_HANDLE;
    VkCommandBuffer commandBuffer = VK_NULL_HANDLE;
    VkQueryPool timestamps = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
    bool running = false;             // submitted, and its fence was not seen to be signalled yet
    std::vector<std::string> labels;  // of the steps
    std::vector<uint64_t> ticks;      // timestamps before the first step and after each step
    bool timed = false;               // ticks hold a finished run
};

inline VkFormat vulkanFormat(ColourFormat colour) {
    switch (colour) {
        case ColourFormat::Halves:
            return VK_FORMAT_R16G16B16A16_SFLOAT;
        default:
            return VK_FORMAT_R8G8B8A8_UNORM;
    }
}

class VulkanBackend final : public Backend, private ResourceView {
public:
    VulkanBackend(std::unique_ptr<Device> device, ShaderPack pack);
    ~VulkanBackend() override;
    Status start();

    const DeviceInfo& info() const override { return device_->info; }
    Result<BufferId> createBuffer(const BufferDesc& desc) override;
    void destroyBuffer(BufferId buffer) override;
    Status write(BufferId buffer, uint64_t offset, std::span<const std::byte> bytes) override;
    std::span<std::byte> mapped(BufferId buffer) override;
    Result<PipelineId> computePipeline(std::string_view shader) override;
    Result<PipelineId> drawPipeline(const DrawPipelineDesc& desc) override;
    uint32_t workgroupSize(PipelineId id) const override { return shader(id) ? shader(id)->workgroup[0] : 0; }
    Result<TargetId> createTarget(const TargetDesc& desc) override;
    void destroyTarget(TargetId target) override;
    Result<FrameId> createFrame(std::vector<Step> steps) override;
    void destroyFrame(FrameId frame) override;
    Status submit(FrameId frame) override;
    bool finished(FrameId frame) override;
    Status wait(FrameId frame) override;
    std::vector<PassTime> passTimes(FrameId frame) const override;
    uint64_t residentBytes() const override;

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
    Status record(Frame& frame, std::span<const Step> steps);
    Status submitAndWait(VkCommandBuffer commands);
    Status waitFor(Frame& frame);
    void ended(Frame& frame);
    void freeFrame(Frame& frame);
    struct Recorder;

    std::unique_ptr<Device> device_;
    const Functions& vk_;  // of device_
    ShaderPack pack_;
    VkFence fence_ = VK_NULL_HANDLE;  // of uploads
    VkCommandPool uploadPool_ = VK_NULL_HANDLE;
    VkCommandBuffer uploadCommands_ = VK_NULL_HANDLE;
    std::map<uint32_t, Buffer> buffers_;
    std::map<uint32_t, Target> targets_;
    std::map<uint32_t, Frame> frames_;
    std::vector<Pipeline> pipelines_;                                                          // PipelineId::value is the index + 1
    std::map<std::tuple<uint32_t, bool, ColourFormat, uint32_t>, VkRenderPass> renderPasses_;  // by layers, depth, colour, samples
    uint32_t lastId_ = 0;
};

}  // namespace dpl::vk
