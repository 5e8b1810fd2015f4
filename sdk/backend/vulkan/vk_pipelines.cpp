// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "sdk/backend/vulkan/vk_backend.h"

namespace dpl::vk {

Result<VkRenderPass> VulkanBackend::renderPass(const TargetDesc& target) {
    const uint32_t layers = target.multiview ? target.views : 0, samples = target.samples;
    const bool depth = target.depth;
    const auto key = std::tuple(layers, depth, samples, target.sampled);
    if (const auto it = renderPasses_.find(key); it != renderPasses_.end()) return it->second;
    const uint32_t targets = depth ? 2 : 1;
    std::array<VkAttachmentDescription, 4>
        attachments{};  // first the images that are drawn; with several samples, then the images that these are resolved into
    for (VkAttachmentDescription& a : attachments) {
        a.samples = VK_SAMPLE_COUNT_1_BIT;
        a.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        a.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        a.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        a.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
        a.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
        a.finalLayout = target.sampled ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    }
    for (uint32_t i = 0; i < 2 * targets; ++i) {
        attachments[i].format = i % targets == 0 ? kColourFormat : device_->depthSumFormat;
        if (samples == 1) continue;
        if (i < targets) {
            attachments[i].samples = VkSampleCountFlagBits(samples);
            attachments[i].storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
            attachments[i].finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        } else {
            attachments[i].loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
        }
    }
    VkAttachmentReference references[4];
    for (uint32_t i = 0; i < 4; ++i) references[i] = {i, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = targets;
    subpass.pColorAttachments = references;
    if (samples > 1) subpass.pResolveAttachments = references + targets;
    VkSubpassDependency dependencies[2]{};
    // A read-back or an app's pass. Both in every pass: pipelines fit only passes with the same dependencies.
    constexpr VkPipelineStageFlags kReader = VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;
    constexpr VkAccessFlags kReads = VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_SHADER_READ_BIT;
    dependencies[0].srcSubpass = VK_SUBPASS_EXTERNAL;  // waits for whoever reads the frame before
    dependencies[0].srcStageMask = kReader | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    dependencies[0].srcAccessMask = kReads | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    dependencies[0].dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    dependencies[0].dstAccessMask = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    dependencies[1].srcSubpass = 0;
    dependencies[1].dstSubpass = VK_SUBPASS_EXTERNAL;  // the reader waits for the draw
    dependencies[1].srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    dependencies[1].srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    dependencies[1].dstStageMask = kReader;
    dependencies[1].dstAccessMask = kReads;
    dependencies[0].dstSubpass = 0;
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = samples > 1 ? 2 * targets : targets;
    info.pAttachments = attachments.data();
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = 2;
    info.pDependencies = dependencies;
    const uint32_t mask = (1u << layers) - 1;
    VkRenderPassMultiviewCreateInfo multiview{VK_STRUCTURE_TYPE_RENDER_PASS_MULTIVIEW_CREATE_INFO};
    multiview.subpassCount = 1;
    multiview.pViewMasks = &mask;
    multiview.correlationMaskCount = 1;
    multiview.pCorrelationMasks = &mask;
    if (layers > 0) info.pNext = &multiview;
    VkRenderPass pass = VK_NULL_HANDLE;
    DPL_VK_MAKE(pass, vk_.vkCreateRenderPass(device_->device, &info, device_->allocator, &pass));
    renderPasses_[key] = pass;
    return pass;
}

Result<VkShaderModule> VulkanBackend::shaderModule(const Shader& shader) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = shader.spirv.size() * 4;
    info.pCode = shader.spirv.data();
    VkShaderModule module = VK_NULL_HANDLE;
    DPL_VK_MAKE(module, vk_.vkCreateShaderModule(device_->device, &info, device_->allocator, &module));
    return module;
}

Status VulkanBackend::makeLayouts(Pipeline& p) {
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    const auto add = [&](const Shader& shader, VkShaderStageFlags stage) {
        for (const ShaderBinding& b : shader.bindings) {
            VkDescriptorSetLayoutBinding binding{};
            binding.binding = b.binding;
            binding.descriptorType = descriptorType(b);
            binding.descriptorCount = 1;
            binding.stageFlags = stage;
            bindings.push_back(binding);
        }
    };
    add(*p.shader, p.shader->stage == ShaderStage::Compute ? VK_SHADER_STAGE_COMPUTE_BIT : VK_SHADER_STAGE_VERTEX_BIT);
    if (p.fragment) add(*p.fragment, VK_SHADER_STAGE_FRAGMENT_BIT);
    VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set.bindingCount = uint32_t(bindings.size());
    set.pBindings = bindings.data();
    DPL_VK_MAKE(p.setLayout, vk_.vkCreateDescriptorSetLayout(device_->device, &set, device_->allocator, &p.setLayout));
    const VkPushConstantRange push{p.stages, 0, std::max(p.shader->pushBytes, p.fragment ? p.fragment->pushBytes : 0)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &p.setLayout;
    layout.pushConstantRangeCount = push.size ? 1 : 0;
    layout.pPushConstantRanges = &push;
    DPL_VK_MAKE(p.layout, vk_.vkCreatePipelineLayout(device_->device, &layout, device_->allocator, &p.layout));
    return {};
}

Status VulkanBackend::makeCompute(Pipeline& p) {
    p.stages = VK_SHADER_STAGE_COMPUTE_BIT;
    DPL_RETURN_IF_ERROR(makeLayouts(p));
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.pName = "main";
    DPL_TRY(info.stage.module, shaderModule(*p.shader));
    info.layout = p.layout;
    const VkResult result = vk_.vkCreateComputePipelines(device_->device, VK_NULL_HANDLE, 1, &info, device_->allocator, &p.pipeline);
    vk_.vkDestroyShaderModule(device_->device, info.stage.module, device_->allocator);
    return result == VK_SUCCESS ? Status() : Status(failVk("vkCreateComputePipelines", result));
}

Status VulkanBackend::makeDraw(Pipeline& p, const DrawPipelineDesc& desc) {
    p.stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    const Shader& fragment = *p.fragment;
    if (!fragment.bindings.empty() && fragment.bindings[0].binding != p.shader->bindings.size())
        return fail(Code::Unsupported, "the bindings of {} do not begin after the {} of {}", fragment.name, p.shader->bindings.size(),
                    p.shader->name);
    DPL_RETURN_IF_ERROR(makeLayouts(p));
    VkPipelineShaderStageCreateInfo stages[2]{};
    stages[0].sType = stages[1].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
    stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[0].pName = stages[1].pName = "main";
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = desc.topology == Topology::List ? VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VkSampleCountFlagBits(desc.samples);
    samples.sampleShadingEnable = desc.samples > 1;  // shade each sample by itself; gl_FragCoord is then the sample's place
    samples.minSampleShading = 1;
    // Premultiplied "over", back to front; alpha holds the transmittance. The depth sums have the same blend state, because another one
    // would need the feature independentBlend.
    VkPipelineColorBlendAttachmentState blend{};
    blend.blendEnable = VK_TRUE;
    blend.srcColorBlendFactor = VK_BLEND_FACTOR_ONE;
    blend.srcAlphaBlendFactor = VK_BLEND_FACTOR_ZERO;
    blend.dstColorBlendFactor = blend.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    blend.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    const VkPipelineColorBlendAttachmentState blends[] = {blend, blend};
    VkPipelineColorBlendStateCreateInfo colour{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    colour.attachmentCount = desc.depth ? 2 : 1;
    colour.pAttachments = blends;
    const VkDynamicState dynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamicInfo{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamicInfo.dynamicStateCount = 2;
    dynamicInfo.pDynamicStates = dynamic;
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    info.stageCount = 2;
    info.pStages = stages;
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pColorBlendState = &colour;
    info.pDynamicState = &dynamicInfo;
    info.layout = p.layout;
    DPL_TRY(info.renderPass, renderPass({0, 0, desc.views, desc.depth, desc.multiview, desc.samples}));
    DPL_TRY(stages[0].module, shaderModule(*p.shader));
    auto second = shaderModule(fragment);
    if (!second) {
        vk_.vkDestroyShaderModule(device_->device, stages[0].module, device_->allocator);
        return second.error();
    }
    stages[1].module = *second;
    const VkResult result = vk_.vkCreateGraphicsPipelines(device_->device, VK_NULL_HANDLE, 1, &info, device_->allocator, &p.pipeline);
    for (const auto& stage : stages) vk_.vkDestroyShaderModule(device_->device, stage.module, device_->allocator);
    return result == VK_SUCCESS ? Status() : Status(failVk("vkCreateGraphicsPipelines", result));
}

void VulkanBackend::freePipeline(Pipeline& p) {
    vk_.vkDestroyPipeline(device_->device, p.pipeline, device_->allocator);
    vk_.vkDestroyPipelineLayout(device_->device, p.layout, device_->allocator);
    vk_.vkDestroyDescriptorSetLayout(device_->device, p.setLayout, device_->allocator);
}

PipelineId VulkanBackend::findPipeline(std::string_view key) const {
    for (size_t i = 0; i < pipelines_.size(); ++i)
        if (pipelines_[i].key == key) return PipelineId{uint32_t(i) + 1};
    return {};
}

const Shader* VulkanBackend::findShader(std::string_view name) const {
    const Shader* texels = device_->info.texels ? pack_.find(std::string(name) + std::string(kTexelsSuffix)) : nullptr;
    return texels ? texels : pack_.find(name);
}

Result<PipelineId> VulkanBackend::computePipeline(std::string_view name) {
    if (PipelineId known = findPipeline(name)) return known;
    Pipeline p;
    p.key = name;
    p.shader = findShader(name);
    if (!p.shader) return fail(Code::NotFound, "no shader {} in the pack", name);
    if (auto status = makeCompute(p); !status) {
        freePipeline(p);
        return status.error();
    }
    pipelines_.push_back(std::move(p));
    return PipelineId{uint32_t(pipelines_.size())};
}

Result<PipelineId> VulkanBackend::drawPipeline(const DrawPipelineDesc& desc) {
    Pipeline p;
    p.key = formatText("{}+{}+{}{}{}+{}{}", desc.vertex, desc.fragment, desc.views, desc.multiview ? "M" : "", desc.depth ? "D" : "",
                       desc.samples, desc.topology == Topology::List ? "T" : "");
    if (PipelineId known = findPipeline(p.key)) return known;
    p.shader = findShader(desc.vertex);
    p.fragment = findShader(desc.fragment);
    if (!p.shader || !p.fragment) return fail(Code::NotFound, "no shader {} or {} in the pack", desc.vertex, desc.fragment);
    if (auto status = makeDraw(p, desc); !status) {
        freePipeline(p);
        return status.error();
    }
    pipelines_.push_back(std::move(p));
    return PipelineId{uint32_t(pipelines_.size())};
}

}  // namespace dpl::vk
