// SPDX-License-Identifier: Apache-2.0
#include "platform/desktop/canvas.h"

#include <array>

#include "finish_frag.h"
#include "finish_vert.h"

namespace dpl::platform {
namespace {

constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr VkPipelineStageFlags kDepthStages = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
constexpr VkPipelineStageFlags kColourStage = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
constexpr VkAccessFlags kColourAccess = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;

VkAttachmentDescription attachmentOf(VkFormat format, uint32_t samples, VkAttachmentLoadOp load, VkImageLayout before,
                                     VkImageLayout after) {
    VkAttachmentDescription a{};
    a.format = format;
    a.samples = VkSampleCountFlagBits(samples);
    a.loadOp = load;
    a.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    a.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    a.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    a.initialLayout = before;
    a.finalLayout = after;
    return a;
}

/** What the subpass waits for, or what waits for it. */
VkSubpassDependency dependency(bool before, VkPipelineStageFlags fromStage, VkAccessFlags fromAccess, VkPipelineStageFlags toStage,
                               VkAccessFlags toAccess) {
    return {before ? VK_SUBPASS_EXTERNAL : 0, before ? 0 : VK_SUBPASS_EXTERNAL, fromStage, toStage, fromAccess, toAccess, 0};
}

template <size_t A, size_t D>
Result<VkRenderPass> makePass(VkDevice device, const std::array<VkAttachmentDescription, A>& attachments,
                              const VkSubpassDescription& subpass, const std::array<VkSubpassDependency, D>& dependencies) {
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = uint32_t(A);
    info.pAttachments = attachments.data();
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = uint32_t(D);
    info.pDependencies = dependencies.data();
    VkRenderPass pass = VK_NULL_HANDLE;
    DPL_VK_MAKE(pass, vkCreateRenderPass, device, info);
    return pass;
}

}  // namespace

Result<std::unique_ptr<Canvas>> Canvas::create(Device& device) {
    std::unique_ptr<Canvas> made(new Canvas(device));
    DPL_SHELL_OK(made->makePasses());
    DPL_SHELL_OK(made->makeFinishing());
    return made;
}

Canvas::~Canvas() {
    destroyImages();
    const VkDevice device = device_.device();
    vkDestroyPipeline(device, pipeline_, nullptr);
    vkDestroyPipelineLayout(device, layout_, nullptr);
    vkDestroyDescriptorPool(device, pool_, nullptr);
    vkDestroyDescriptorSetLayout(device, setLayout_, nullptr);
    vkDestroySampler(device, sampler_, nullptr);
    for (VkRenderPass pass : {room_, composing_, finishing_}) vkDestroyRenderPass(device, pass, nullptr);
}

Status Canvas::makePasses() {
    const VkDevice device = device_.device();
    constexpr auto kClear = VK_ATTACHMENT_LOAD_OP_CLEAR, kLoad = VK_ATTACHMENT_LOAD_OP_LOAD, kDrop = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    constexpr auto kUndefined = VK_IMAGE_LAYOUT_UNDEFINED, kColour = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    const VkAttachmentReference first{0, kColour}, second{1, kColour}, depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &first;
    subpass.pDepthStencilAttachment = &depth;
    // The frame before reads depth in compute shaders, and colour in its composing pass.
    DPL_SHELL_TRY(
        room_,
        makePass(
            device,
            std::array{attachmentOf(kLightFormat, kCanvasSamples, kClear, kUndefined, kColour),
                       attachmentOf(kDepthFormat, kCanvasSamples, kClear, kUndefined, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL)},
            subpass,
            std::array{
                dependency(true, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | kColourStage | kDepthStages,
                           VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, kColourStage | kDepthStages,
                           kColourAccess | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT),
                dependency(false, kColourStage | kDepthStages,
                           VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
                           VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | kColourStage, VK_ACCESS_SHADER_READ_BIT | kColourAccess)}));
    // The finishing pass of the frame before reads the resolved image.
    subpass.pDepthStencilAttachment = nullptr;
    subpass.pResolveAttachments = &second;
    DPL_SHELL_TRY(composing_,
                  makePass(device,
                           std::array{attachmentOf(kLightFormat, kCanvasSamples, kLoad, kColour, kColour),
                                      attachmentOf(kLightFormat, 1, kDrop, kUndefined, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)},
                           subpass,
                           std::array{dependency(true, kColourStage | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                                                 VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, kColourStage, kColourAccess),
                                      dependency(false, kColourStage, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                                                 VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT)}));
    // The frame before copies the picture.
    subpass.pResolveAttachments = nullptr;
    DPL_SHELL_TRY(
        finishing_,
        makePass(device, std::array{attachmentOf(kPictureFormat, 1, kDrop, kUndefined, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL)}, subpass,
                 std::array{dependency(true, VK_PIPELINE_STAGE_TRANSFER_BIT | kColourStage, 0, kColourStage, kColourAccess),
                            dependency(false, kColourStage, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                       VK_ACCESS_TRANSFER_READ_BIT)}));
    return {};
}

Status Canvas::makeFinishing() {
    const VkDevice device = device_.device();
    VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampler.addressModeU = sampler.addressModeV = sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    DPL_VK_MAKE(sampler_, vkCreateSampler, device, sampler);
    const VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo setLayout{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    setLayout.bindingCount = 1;
    setLayout.pBindings = &binding;
    DPL_VK_MAKE(setLayout_, vkCreateDescriptorSetLayout, device, setLayout);
    const VkDescriptorPoolSize poolSize{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &poolSize;
    DPL_VK_MAKE(pool_, vkCreateDescriptorPool, device, pool);
    VkDescriptorSetAllocateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    set.descriptorPool = pool_;
    set.descriptorSetCount = 1;
    set.pSetLayouts = &setLayout_;
    DPL_VK(vkAllocateDescriptorSets(device, &set, &set_));
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &setLayout_;
    DPL_VK_MAKE(layout_, vkCreatePipelineLayout, device, layout);

    TriangleDrawing drawing;
    drawing.layout = layout_, drawing.pass = finishing_;
    drawing.vertexShader = finish_vert, drawing.fragmentShader = finish_frag;
    DPL_SHELL_TRY(pipeline_, makePipeline(device, drawing));
    return {};
}

Status Canvas::makeImages() {
    const VulkanHandles& on = device_.handles();
    constexpr VkImageUsageFlags kAttachment = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    DPL_SHELL_TRY(light_, makeImage(on, kLightFormat, size_, 0, kCanvasSamples, kAttachment, VK_IMAGE_ASPECT_COLOR_BIT));
    DPL_SHELL_TRY(depthImage_,
                  makeImage(on, kDepthFormat, size_, 1, kCanvasSamples,
                            VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT, VK_IMAGE_ASPECT_DEPTH_BIT));
    DPL_SHELL_TRY(resolved_, makeImage(on, kLightFormat, size_, 0, 1, kAttachment | VK_IMAGE_USAGE_SAMPLED_BIT, VK_IMAGE_ASPECT_COLOR_BIT));
    DPL_SHELL_TRY(picture_,
                  makeImage(on, kPictureFormat, size_, 0, 1, kAttachment | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_ASPECT_COLOR_BIT));
    DPL_SHELL_TRY(roomFrame_, makeFramebuffer(on.device, room_, std::array{light_.view, depthImage_.view}, size_));
    DPL_SHELL_TRY(composingFrame_, makeFramebuffer(on.device, composing_, std::array{light_.view, resolved_.view}, size_));
    DPL_SHELL_TRY(finishingFrame_, makeFramebuffer(on.device, finishing_, std::array{picture_.view}, size_));
    const VkDescriptorImageInfo image{sampler_, resolved_.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set_;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    write.pImageInfo = &image;
    vkUpdateDescriptorSets(device_.device(), 1, &write, 0, nullptr);
    return {};
}

void Canvas::destroyImages() {
    for (VkFramebuffer* framebuffer : {&roomFrame_, &composingFrame_, &finishingFrame_}) {
        vkDestroyFramebuffer(device_.device(), *framebuffer, nullptr);
        *framebuffer = VK_NULL_HANDLE;
    }
    for (Image* image : {&light_, &depthImage_, &resolved_, &picture_}) destroyImage(device_.handles(), *image);
}

Status Canvas::resize(VkExtent2D size) {
    if (size.width == size_.width && size.height == size_.height) return {};
    DPL_SHELL_OK(device_.waitIdle());
    destroyImages();
    size_ = size;
    Status made = makeImages();
    if (!made) size_ = {};
    return made;
}

void Canvas::begin(VkCommandBuffer commands, VkRenderPass pass, VkFramebuffer framebuffer) const {
    const VkClearValue clear[2] = {};  // black, and infinitely far
    VkRenderPassBeginInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    info.renderPass = pass;
    info.framebuffer = framebuffer;
    info.renderArea.extent = size_;
    info.clearValueCount = 2;
    info.pClearValues = clear;
    vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
}

void Canvas::beginRoom(VkCommandBuffer commands) const {
    begin(commands, room_, roomFrame_);
}

void Canvas::beginComposing(VkCommandBuffer commands) const {
    begin(commands, composing_, composingFrame_);
}

void Canvas::beginFinishing(VkCommandBuffer commands) const {
    begin(commands, finishing_, finishingFrame_);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    const VkViewport viewport{0, 0, float(size_.width), float(size_.height), 0, 1};
    const VkRect2D scissor{{0, 0}, size_};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set_, 0, nullptr);
    vkCmdDraw(commands, 3, 1, 0, 0);
}

}  // namespace dpl::platform
