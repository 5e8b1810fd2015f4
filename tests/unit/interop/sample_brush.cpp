// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/interop/sample_brush.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "fetch_four.h"
#include "fetch_one.h"
#include "paint_frag.h"
#include "paint_vert.h"

namespace dpl::test {
namespace {

constexpr size_t kFloats = sizeof(SampleValue) / sizeof(float);
static_assert(kFloats == 5);

struct BrushPush {
    uint32_t widthPx, samples, index;  // of a sample, or of a layer
};

template <class T>
T made(doppel::Result<T> result) {
    if (result) return *result;
    std::fprintf(stderr, "%s\n", result.error().message.c_str());
    std::abort();
}

}  // namespace

SampleBrush::~SampleBrush() {
    platform::destroyHostBuffer({app_.physical, app_.device}, buffer_);
    for (auto& [key, kit] : kits_) {
        vkDestroyPipeline(app_.device, kit.pipeline, nullptr);
        vkDestroyRenderPass(app_.device, kit.pass, nullptr);
    }
    for (VkPipeline pipeline : readers_) vkDestroyPipeline(app_.device, pipeline, nullptr);
    for (Layout* layout : {&painting_, &reading_}) {
        vkDestroyDescriptorPool(app_.device, layout->pool, nullptr);
        vkDestroyPipelineLayout(app_.device, layout->layout, nullptr);
        vkDestroyDescriptorSetLayout(app_.device, layout->set, nullptr);
    }
}

void SampleBrush::makeLayout(Layout& made, bool images, VkShaderStageFlags stage) {
    if (made.set) return;
    VkDescriptorSetLayoutBinding bindings[3]{};
    const uint32_t count = images ? 3 : 1;
    for (uint32_t i = 0; i < count; ++i) {
        const VkDescriptorType type = i + 1 == count ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER : VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
        bindings[i] = {i, type, 1, stage, nullptr};
    }
    VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set.bindingCount = count;
    set.pBindings = bindings;
    MUST(vkCreateDescriptorSetLayout(app_.device, &set, nullptr, &made.set));
    const VkPushConstantRange push{stage, 0, sizeof(BrushPush)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = layout.pushConstantRangeCount = 1;
    layout.pSetLayouts = &made.set;
    layout.pPushConstantRanges = &push;
    MUST(vkCreatePipelineLayout(app_.device, &layout, nullptr, &made.layout));
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1}, {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 2}};
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = images ? 2 : 1;
    pool.pPoolSizes = sizes;
    MUST(vkCreateDescriptorPool(app_.device, &pool, nullptr, &made.pool));
    VkDescriptorSetAllocateInfo allocation{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocation.descriptorPool = made.pool;
    allocation.descriptorSetCount = 1;
    allocation.pSetLayouts = &made.set;
    MUST(vkAllocateDescriptorSets(app_.device, &allocation, &made.descriptors));
}

void SampleBrush::makeBuffer(size_t values) {
    if (values <= capacity_) return;
    const platform::VulkanHandles on{app_.physical, app_.device};
    platform::destroyHostBuffer(on, buffer_);
    buffer_ = made(platform::makeHostBuffer(on, values * sizeof(SampleValue), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
    capacity_ = values;
}

SampleBrush::Kit& SampleBrush::kitFor(const AppImage& colour, const AppImage& depth) {
    Kit& kit = kits_[{uint32_t(colour.format), uint32_t(depth.format), colour.samples}];
    if (kit.pipeline) return kit;
    kit.pass = app_.makePass(colour.format, colour.samples, 0, depth.format);
    platform::TriangleDrawing drawing;
    drawing.layout = painting_.layout, drawing.pass = kit.pass, drawing.samples = colour.samples;
    drawing.vertexShader = paint_vert, drawing.fragmentShader = paint_frag;
    drawing.depth = VK_COMPARE_OP_ALWAYS;
    kit.pipeline = made(platform::makePipeline(app_.device, drawing));
    return kit;
}

VkPipeline SampleBrush::reader(uint32_t samples) {
    VkPipeline& pipeline = readers_[samples == 1 ? 0 : 1];
    if (pipeline) return pipeline;
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = made(platform::makeShaderModule(app_.device, samples == 1 ? std::span<const uint32_t>(fetch_one) : fetch_four));
    info.stage.pName = "main";
    info.layout = reading_.layout;
    MUST(vkCreateComputePipelines(app_.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline));
    vkDestroyShaderModule(app_.device, info.stage.module, nullptr);
    return pipeline;
}

void SampleBrush::paint(const AppImage& colour, const AppImage& depth, uint32_t layer, std::span<const SampleValue> values) {
    app_.waitAll();
    makeLayout(painting_, false, VK_SHADER_STAGE_FRAGMENT_BIT);
    const Kit& kit = kitFor(colour, depth);
    makeBuffer(values.size());
    std::memcpy(buffer_.mapped, values.data(), values.size_bytes());
    const VkDescriptorBufferInfo buffer{buffer_.buffer, 0, VK_WHOLE_SIZE};
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = painting_.descriptors;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = &buffer;
    vkUpdateDescriptorSets(app_.device, 1, &write, 0, nullptr);
    const VkFramebuffer framebuffer =
        app_.makeFramebuffer(kit.pass, {colour.layerViews[layer], depth.layerViews[layer]}, colour.width, colour.height);
    const VkCommandBuffer commands = app_.begin(AppDevice::kUploadSlot);
    app_.barrier(commands, colour, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = kit.pass;
    begin.framebuffer = framebuffer;
    begin.renderArea.extent = {colour.width, colour.height};
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, kit.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, painting_.layout, 0, 1, &painting_.descriptors, 0, nullptr);
    const VkViewport viewport{0, 0, float(colour.width), float(colour.height), 0, 1};
    const VkRect2D scissor{{0, 0}, {colour.width, colour.height}};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    for (uint32_t s = 0; s < colour.samples; ++s) {
        const BrushPush push{colour.width, colour.samples, s};
        vkCmdPushConstants(commands, painting_.layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push, &push);
        vkCmdDraw(commands, 3, 1, 0, 0);
    }
    vkCmdEndRenderPass(commands);
    app_.barrier(commands, colour, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    app_.barrier(commands, depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    app_.submit(AppDevice::kUploadSlot);
    app_.waitAll();
    vkDestroyFramebuffer(app_.device, framebuffer, nullptr);
}

std::vector<SampleValue> SampleBrush::fetch(const AppImage& colour, const AppImage& depth, uint32_t layer) {
    app_.waitAll();
    makeLayout(reading_, true, VK_SHADER_STAGE_COMPUTE_BIT);
    std::vector<SampleValue> values(size_t(colour.width) * colour.height * colour.samples);
    makeBuffer(values.size());
    const VkDescriptorImageInfo images[2] = {{VK_NULL_HANDLE, colour.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL},
                                             {VK_NULL_HANDLE, depth.view, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL}};
    const VkDescriptorBufferInfo buffer{buffer_.buffer, 0, VK_WHOLE_SIZE};
    VkWriteDescriptorSet writes[3]{};
    for (uint32_t i = 0; i < 3; ++i) {
        writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        writes[i].dstSet = reading_.descriptors;
        writes[i].dstBinding = i;
        writes[i].descriptorCount = 1;
        writes[i].descriptorType = i < 2 ? VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        if (i < 2)
            writes[i].pImageInfo = &images[i];
        else
            writes[i].pBufferInfo = &buffer;
    }
    vkUpdateDescriptorSets(app_.device, 3, writes, 0, nullptr);
    const VkPipeline pipeline = reader(colour.samples);
    const VkCommandBuffer commands = app_.begin(AppDevice::kUploadSlot);
    app_.barrier(commands, colour, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    app_.barrier(commands, depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, reading_.layout, 0, 1, &reading_.descriptors, 0, nullptr);
    const BrushPush push{colour.width, colour.samples, layer};
    vkCmdPushConstants(commands, reading_.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, &push);
    vkCmdDispatch(commands, (colour.width + 63) / 64, colour.height, 1);
    app_.barrier(commands, colour, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    app_.barrier(commands, depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    VkMemoryBarrier host{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    host.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
    host.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &host, 0, nullptr, 0, nullptr);
    app_.submit(AppDevice::kUploadSlot);
    app_.waitAll();
    std::memcpy(values.data(), buffer_.mapped, values.size() * sizeof(SampleValue));
    return values;
}

}  // namespace dpl::test
