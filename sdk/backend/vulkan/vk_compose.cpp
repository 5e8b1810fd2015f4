// SPDX-License-Identifier: Apache-2.0
// Composes pictures into the passes of an app that lends its device.
#include <algorithm>
#include <bit>

#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::vk {
namespace {

/** How a format of a target stores light. */
struct TargetFormat {
    VkFormat format;
    bool linear;  // blends linear light; else display-referred values
};
constexpr TargetFormat kTargetFormats[] = {
    {VK_FORMAT_R8G8B8A8_UNORM, false}, {VK_FORMAT_B8G8R8A8_UNORM, false},     {VK_FORMAT_R8G8B8A8_SRGB, true},
    {VK_FORMAT_B8G8R8A8_SRGB, true},   {VK_FORMAT_R16G16B16A16_SFLOAT, true}, {VK_FORMAT_A2B10G10R10_UNORM_PACK32, false},
};

// Bindings of compose.depth, in this order. compose.frag has the first image and buffers; both use the same descriptor sets.
enum : uint32_t { kDrawn, kTiled, kSums, kMesh, kBindings };
constexpr uint32_t kImages = 2, kBuffers = 2;
constexpr uint32_t kSets = gpu::kMaxViews * kAppSlots;  // of pictures; and of scenes, each with an image and a buffer

bool hasDepth(VkFormat format) {
    return (format >= VK_FORMAT_D16_UNORM && format <= VK_FORMAT_D32_SFLOAT) ||
           (format >= VK_FORMAT_D16_UNORM_S8_UINT && format <= VK_FORMAT_D32_SFLOAT_S8_UINT);
}

}  // namespace

/** Makes the layout that all composers share, and a mark and descriptor sets for each slot. */
Status VulkanBackend::makeLayerSlots() {
    marks_.desc = {"marks", kAppSlots * sizeof(uint32_t), BufferMemory::Readback};
    DPL_RETURN_IF_ERROR(makeBuffer(marks_));
    DPL_TRY(unread_.target, createTarget({.widthPx = 1, .heightPx = 1, .multiview = info().multiview, .sampled = true}));
    DPL_TRY(unread_.buffer, createBuffer({"unread", 16}));
    composeLayout_.shader = pack_.find("compose.vert");
    composeLayout_.fragment = pack_.find("compose.depth");
    if (!composeLayout_.shader || !composeLayout_.fragment) return fail(Code::Internal, "the shader pack has no compose shaders");
    composeLayout_.stages = VK_SHADER_STAGE_FRAGMENT_BIT;
    DPL_RETURN_IF_ERROR(makeLayouts(composeLayout_));
    DPL_TRY(readScene_[0], computePipeline("scene.read"));
    DPL_TRY(readScene_[1], computePipeline("scene.read.four"));
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, (kImages + 1) * kSets},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, (kBuffers + 1) * kSets}};
    VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    info.maxSets = 2 * kSets;
    info.poolSizeCount = 2;
    info.pPoolSizes = sizes;
    DPL_VK_MAKE(layerDescriptors_, vk_.vkCreateDescriptorPool(device_->device, &info, device_->allocator, &layerDescriptors_));
    for (LayerSlot& slot : layerSlots_) {
        for (VkDescriptorSet& picture : slot.descriptors) {
            DPL_TRY(picture, layerDescriptors(composeLayout_.setLayout));
        }
        for (VkDescriptorSet& scene : slot.scenes) {
            DPL_TRY(scene, layerDescriptors(pipelines_[readScene_[0].value - 1].setLayout));  // both kernels have the same bindings
        }
    }
    return {};
}

Result<VkDescriptorSet> VulkanBackend::layerDescriptors(VkDescriptorSetLayout layout) {
    VkDescriptorSetAllocateInfo allocation{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocation.descriptorPool = layerDescriptors_;
    allocation.descriptorSetCount = 1;
    allocation.pSetLayouts = &layout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    DPL_VK(vk_.vkAllocateDescriptorSets(device_->device, &allocation, &set));
    return set;
}

Status VulkanBackend::readScene(const SceneRead& read, const SceneImage& image) {
    const Buffer& to = buffers_.at(read.scene.value);
    const VkDescriptorSet set = layerSlots_[read.slot].scenes[read.view];
    const VkDescriptorImageInfo from{VK_NULL_HANDLE, image.view, image.layout};
    const VkDescriptorBufferInfo written{to.buffer, 0, to.desc.bytes};
    VkWriteDescriptorSet writes[2]{};
    for (uint32_t i = 0; i < 2; ++i) {
        writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        writes[i].dstSet = set;
        writes[i].dstBinding = i;
        writes[i].descriptorCount = 1;
    }
    writes[0].descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, writes[0].pImageInfo = &from;
    writes[1].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, writes[1].pBufferInfo = &written;
    vk_.vkUpdateDescriptorSets(device_->device, 2, writes, 0, nullptr);
    const Pipeline& pipeline = pipelines_[readScene_[image.samples == 1 ? 0 : 1].value - 1];
    const gpu::ScenePush push = scenePush(read, image.place);
    const auto buffer = static_cast<VkCommandBuffer>(read.commands.handle);
    vk_.vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.pipeline);
    vk_.vkCmdBindDescriptorSets(buffer, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout, 0, 1, &set, 0, nullptr);
    vk_.vkCmdPushConstants(buffer, pipeline.layout, pipeline.stages, 0, sizeof push, &push);
    vk_.vkCmdDispatch(buffer, (read.widthPx + gpu::kSceneGroup - 1) / gpu::kSceneGroup, read.heightPx, 1);
    return {};
}

Result<VkPipeline> VulkanBackend::composePipeline(const AppPass& pass, const Shader& fragment, VkCompareOp nearer) {
    const bool writesDepth = nearer != VK_COMPARE_OP_ALWAYS;
    VkPipelineShaderStageCreateInfo stages[2]{};
    stages[0].sType = stages[1].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
    stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[0].pName = stages[1].pName = "main";
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VkSampleCountFlagBits(pass.samples);
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = depth.depthWriteEnable = writesDepth;
    depth.depthCompareOp = nearer;
    VkPipelineColorBlendAttachmentState blend{};  // premultiplied "over", or no colour
    blend.blendEnable = !writesDepth;
    blend.srcColorBlendFactor = blend.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    blend.dstColorBlendFactor = blend.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    if (!writesDepth)
        blend.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    VkPipelineColorBlendStateCreateInfo colour{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    colour.attachmentCount = 1;
    colour.pAttachments = &blend;
    const VkDynamicState dynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamicInfo{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamicInfo.dynamicStateCount = 2;
    dynamicInfo.pDynamicStates = dynamic;
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    rendering.viewMask = pass.viewMask;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachmentFormats = &pass.colour;
    rendering.depthAttachmentFormat = pass.depth;
    rendering.stencilAttachmentFormat = pass.stencil;
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    if (!pass.renderPass) info.pNext = &rendering;
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &colour;
    info.pDynamicState = &dynamicInfo;
    info.layout = composeLayout_.layout;
    info.renderPass = pass.renderPass;
    info.subpass = pass.subpass;
    DPL_TRY(stages[0].module, shaderModule(*composeLayout_.shader));
    auto second = shaderModule(fragment);
    VkPipeline pipeline = VK_NULL_HANDLE;
    VkResult result = VK_SUCCESS;
    if (second) {
        stages[1].module = *second;
        result = vk_.vkCreateGraphicsPipelines(device_->device, VK_NULL_HANDLE, 1, &info, device_->allocator, &pipeline);
        vk_.vkDestroyShaderModule(device_->device, stages[1].module, device_->allocator);
    }
    vk_.vkDestroyShaderModule(device_->device, stages[0].module, device_->allocator);
    if (!second) return second.error();
    if (result != VK_SUCCESS) return failVk("vkCreateGraphicsPipelines", result);
    return pipeline;
}

/** Whether the pass blends light, rather than display-referred values. Unsupported: Doppel cannot draw in it. */
Result<bool> VulkanBackend::blendsLight(const AppPass& pass) const {
    if (!device_->lent) return fail(Code::Unsupported, "only a context on the app's own Vulkan device composes into its passes");
    const auto* known =
        std::find_if(std::begin(kTargetFormats), std::end(kTargetFormats), [&](auto& f) { return f.format == pass.colour; });
    if (known == std::end(kTargetFormats))
        return fail(Code::Unsupported,
                    "targets of VkFormat {} are not possible; use RGBA8 or BGRA8 as UNORM or SRGB, R16G16B16A16_SFLOAT or "
                    "A2B10G10R10_UNORM_PACK32",
                    int(pass.colour));
    if (pass.samples != 1 && pass.samples != 4)
        return fail(Code::Unsupported, "a pass of {} samples a pixel is not possible; 1 and 4 are", pass.samples);
    if (pass.viewMask != 0 && !device_->info.multiview)
        return fail(Code::Unsupported,
                    "the pass has a view mask, but the feature multiview is not enabled, or the driver of {} draws it wrong; use a pass "
                    "for each view",
                    device_->info.name);
    if (pass.viewMask >= 1u << gpu::kMaxViews)
        return fail(Code::Unsupported, "the view mask {} has views above {}", pass.viewMask, gpu::kMaxViews - 1);
    if (pass.written != PictureDepth::None && !pass.renderPass && !hasDepth(pass.depth))
        return fail(Code::Unsupported, "the pass writes depth, but its depthFormat is VkFormat {}, which holds none", int(pass.depth));
    return known->linear;
}

Result<ComposerId> VulkanBackend::createComposer(const AppPass& pass) {
    DPL_TRY(const bool linear, blendsLight(pass));
    Composer composer;
    if (const Status made = makePipelines(composer, pass); !made) {
        freeComposer(composer);
        return made.error();
    }
    const ComposerId id = addComposer({linear, uint32_t(std::bit_width(pass.viewMask)), pass.written});
    composers_.emplace(id.value, composer);
    return id;
}

Status VulkanBackend::makePipelines(Composer& composer, const AppPass& pass) {
    const Shader* colour = pack_.find(pass.viewMask ? "compose.frag.multiview" : "compose.frag");
    const Shader* depth = pack_.find(pass.viewMask ? "compose.depth.multiview" : "compose.depth");
    if (!colour || !depth) return fail(Code::Internal, "the shader pack has no compose.frag or compose.depth for this pass");
    DPL_TRY(composer.pipeline, composePipeline(pass, *colour, VK_COMPARE_OP_ALWAYS));
    if (pass.written == PictureDepth::None) return {};
    DPL_TRY(composer.writeDepth[0], composePipeline(pass, *depth, VK_COMPARE_OP_LESS));
    DPL_TRY(composer.writeDepth[1], composePipeline(pass, *depth, VK_COMPARE_OP_GREATER));
    return {};
}

void VulkanBackend::freeComposer(Composer& composer) {
    for (VkPipeline pipeline : {composer.pipeline, composer.writeDepth[0], composer.writeDepth[1]})
        vk_.vkDestroyPipeline(device_->device, pipeline, device_->allocator);
}

void VulkanBackend::retireComposer(ComposerId id) {
    const auto it = composers_.find(id.value);
    Composer& composer = it->second;
    for (const VkPipeline pipeline : {composer.pipeline, composer.writeDepth[0], composer.writeDepth[1]})
        if (pipeline) retire(pipeline, 0);  // a slot that was encoded before may be composed with it
    composers_.erase(it);
}

void VulkanBackend::setLayer(uint32_t slot, uint32_t view, const LayerPlace& place) {
    const Target& target = targets_.at((place.target ? place.target : unread_.target).value);
    const TargetDesc& desc = target.desc;
    const Surface& surface = target.surfaces[desc.multiview || !place.target ? 0 : place.view];
    const auto bound = [&](BufferId id) -> const Buffer& { return buffers_.at((id ? id : unread_.buffer).value); };
    VkDescriptorImageInfo images[kBindings]{};
    images[kDrawn] = {VK_NULL_HANDLE, surface.colour.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    images[kSums] = {VK_NULL_HANDLE, desc.depth ? surface.depth.view : surface.colour.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    VkDescriptorBufferInfo buffers[kBindings]{};
    const Buffer &tiled = bound(place.tilePixels), &mesh = bound(place.meshDepth);
    buffers[kTiled] = {tiled.buffer, 0, tiled.desc.bytes};
    buffers[kMesh] = {mesh.buffer, 0, mesh.desc.bytes};
    VkWriteDescriptorSet writes[kBindings]{};
    for (uint32_t i = 0; i < kBindings; ++i) {
        writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        writes[i].dstSet = layerSlots_[slot].descriptors[view];
        writes[i].dstBinding = i;
        writes[i].descriptorCount = 1;
        writes[i].descriptorType = images[i].imageView ? VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        writes[i].pImageInfo = &images[i];
        writes[i].pBufferInfo = &buffers[i];
    }
    vk_.vkUpdateDescriptorSets(device_->device, kBindings, writes, 0, nullptr);
}

Status VulkanBackend::drawPicture(const PictureDraw& what, PassCommands pass) {
    const auto buffer = static_cast<VkCommandBuffer>(pass.handle);
    const Composer& composer = composers_.at(what.composer.value);
    const PicturePlace place = what.place;
    const uint32_t widthPx = what.push[0].widthPx, heightPx = what.push[0].heightPx;
    // A scissor begins at 0 or beyond, so a picture that begins left of the target or above it is cut there.
    const VkViewport viewport{float(place.x), float(place.y), float(widthPx), float(heightPx), 0, 1};
    const VkOffset2D first{std::max(place.x, 0), std::max(place.y, 0)};
    const auto extent = [](int32_t from, int32_t at, uint32_t size) { return uint32_t(std::max<int64_t>(int64_t(at) + size - from, 0)); };
    const VkRect2D scissor{first, {extent(first.x, place.x, widthPx), extent(first.y, place.y, heightPx)}};
    vk_.vkCmdBindPipeline(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS,
                          what.depth ? composer.writeDepth[what.greaterIsNearer] : composer.pipeline);
    vk_.vkCmdSetViewport(buffer, 0, 1, &viewport);
    vk_.vkCmdSetScissor(buffer, 0, 1, &scissor);
    for (uint32_t i = 0; i < what.draws; ++i) {
        const gpu::ComposePush& push = what.push[i];
        vk_.vkCmdBindDescriptorSets(buffer, VK_PIPELINE_BIND_POINT_GRAPHICS, composeLayout_.layout, 0, 1,
                                    &layerSlots_[what.slot].descriptors[push.view], 0, nullptr);
        vk_.vkCmdPushConstants(buffer, composeLayout_.layout, composeLayout_.stages, 0, sizeof push, &push);
        vk_.vkCmdDraw(buffer, 3, 1, 0, 0);
    }
    return {};
}

}  // namespace dpl::vk
