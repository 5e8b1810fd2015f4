// SPDX-License-Identifier: Apache-2.0
#include "platform/common/vulkan_help.h"

#include <algorithm>

namespace dpl::platform {
Result<uint32_t> memoryTypeOf(VkPhysicalDevice physical, uint32_t allowed, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(physical, &memory);
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
        if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    return Error{DPL_ERROR_UNSUPPORTED, "the graphics device has no memory of the kind that is needed"};
}

Result<Image> makeImage(const VulkanHandles& on, VkFormat format, VkExtent2D size, uint32_t layers, uint32_t samples,
                        VkImageUsageFlags usage, VkImageAspectFlags aspect) {
    Image made;
    const auto make = [&]() -> Status {
        VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
        info.imageType = VK_IMAGE_TYPE_2D;
        info.format = format;
        info.extent = {size.width, size.height, 1};
        info.mipLevels = 1;
        info.arrayLayers = std::max(1u, layers);
        info.samples = VkSampleCountFlagBits(samples);
        info.usage = usage;
        DPL_VK_MAKE(made.image, vkCreateImage, on.device, info);
        VkMemoryRequirements needs{};
        vkGetImageMemoryRequirements(on.device, made.image, &needs);
        VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        allocation.allocationSize = needs.size;
        DPL_SHELL_TRY(allocation.memoryTypeIndex, memoryTypeOf(on.physical, needs.memoryTypeBits, 0));
        DPL_VK_MAKE(made.memory, vkAllocateMemory, on.device, allocation);
        DPL_VK(vkBindImageMemory(on.device, made.image, made.memory, 0));
        VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
        view.image = made.image;
        view.viewType = layers > 0 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
        view.format = format;
        view.subresourceRange = {aspect, 0, 1, 0, info.arrayLayers};
        DPL_VK_MAKE(made.view, vkCreateImageView, on.device, view);
        return {};
    };
    if (const Status done = make(); !done) {
        destroyImage(on, made);
        return done.error();
    }
    return made;
}

void destroyImage(const VulkanHandles& on, Image& image) {
    vkDestroyImageView(on.device, image.view, nullptr);
    vkDestroyImage(on.device, image.image, nullptr);
    vkFreeMemory(on.device, image.memory, nullptr);
    image = {};
}

Result<HostBuffer> makeHostBuffer(const VulkanHandles& on, VkDeviceSize bytes, VkBufferUsageFlags usage) {
    HostBuffer made;
    const auto make = [&]() -> Status {
        VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
        info.size = bytes;
        info.usage = usage;
        DPL_VK_MAKE(made.buffer, vkCreateBuffer, on.device, info);
        VkMemoryRequirements needs{};
        vkGetBufferMemoryRequirements(on.device, made.buffer, &needs);
        VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        allocation.allocationSize = needs.size;
        constexpr VkMemoryPropertyFlags kWanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
        DPL_SHELL_TRY(allocation.memoryTypeIndex, memoryTypeOf(on.physical, needs.memoryTypeBits, kWanted));
        DPL_VK_MAKE(made.memory, vkAllocateMemory, on.device, allocation);
        DPL_VK(vkBindBufferMemory(on.device, made.buffer, made.memory, 0));
        DPL_VK(vkMapMemory(on.device, made.memory, 0, VK_WHOLE_SIZE, 0, &made.mapped));
        return {};
    };
    if (const Status done = make(); !done) {
        destroyHostBuffer(on, made);
        return done.error();
    }
    return made;
}

void destroyHostBuffer(const VulkanHandles& on, HostBuffer& buffer) {
    vkDestroyBuffer(on.device, buffer.buffer, nullptr);
    vkFreeMemory(on.device, buffer.memory, nullptr);  // unmaps it too
    buffer = {};
}

Result<VkFramebuffer> makeFramebuffer(VkDevice device, VkRenderPass pass, std::span<const VkImageView> views, VkExtent2D size) {
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    info.renderPass = pass;
    info.attachmentCount = uint32_t(views.size());
    info.pAttachments = views.data();
    info.width = size.width, info.height = size.height, info.layers = 1;
    VkFramebuffer made = VK_NULL_HANDLE;
    DPL_VK_MAKE(made, vkCreateFramebuffer, device, info);
    return made;
}

Result<VkShaderModule> makeShaderModule(VkDevice device, std::span<const uint32_t> words) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = words.size_bytes();
    info.pCode = words.data();
    VkShaderModule module = VK_NULL_HANDLE;
    DPL_VK_MAKE(module, vkCreateShaderModule, device, info);
    return module;
}

Result<VkPipeline> makePipeline(VkDevice device, const TriangleDrawing& drawing) {
    const auto vertex = makeShaderModule(device, drawing.vertexShader);
    if (!vertex) return vertex.error();
    const auto fragment = makeShaderModule(device, drawing.fragmentShader);
    if (!fragment) {
        vkDestroyShaderModule(device, *vertex, nullptr);
        return fragment.error();
    }
    VkPipelineShaderStageCreateInfo stages[2]{};
    stages[0].sType = stages[1].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT, stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[0].module = *vertex, stages[1].module = *fragment;
    stages[0].pName = stages[1].pName = "main";
    stages[1].pSpecializationInfo = drawing.special;
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.cullMode = drawing.frontOnly ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE;
    raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VkSampleCountFlagBits(drawing.samples);
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = drawing.depth.has_value();
    depth.depthWriteEnable = drawing.depth.has_value() && !drawing.over;
    depth.depthCompareOp = drawing.depth.value_or(VK_COMPARE_OP_NEVER);
    VkPipelineColorBlendAttachmentState write{};
    write.colorWriteMask = 0xF;
    write.blendEnable = drawing.over;
    write.srcColorBlendFactor = VK_BLEND_FACTOR_SRC_ALPHA, write.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    write.dstColorBlendFactor = write.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    VkPipelineColorBlendStateCreateInfo colour{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    colour.attachmentCount = 1;
    colour.pAttachments = &write;
    const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamic.dynamicStateCount = 2;
    dynamic.pDynamicStates = states;
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &drawing.input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &colour;
    info.pDynamicState = &dynamic;
    info.layout = drawing.layout;
    info.renderPass = drawing.pass;
    info.subpass = drawing.subpass;
    VkPipeline pipeline = VK_NULL_HANDLE;
    const VkResult made = vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
    for (const auto& stage : stages) vkDestroyShaderModule(device, stage.module, nullptr);
    if (made != VK_SUCCESS) return vulkanError(made, "vkCreateGraphicsPipelines");
    return pipeline;
}

}  // namespace dpl::platform
