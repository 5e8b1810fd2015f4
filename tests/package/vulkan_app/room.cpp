// SPDX-License-Identifier: Apache-2.0
#include "room.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "glass_frag.h"
#include "room_frag.h"
#include "room_vert.h"

namespace {

struct Push {
    float view[12], lens[4], near;
};

constexpr uint32_t kBoxes = 5;              // and the glass
constexpr uint32_t kGlassFrontVertex = 30;  // of the side that faces +z
// As in room.vert.
constexpr float kLow[kBoxes + 1][3] = {{-4, -0.1f, -4},    {-4, 0, -4.1f},    {-1.15f, 0, 0.5f},
                                       {-0.15f, 0, -1.2f}, {0.75f, 0, 0.45f}, {-0.95f, 0.5f, 0.29f}};
constexpr float kHigh[kBoxes + 1][3] = {{4, 0, 6},         {4, 3, -4},        {-0.95f, 3, 0.7f},
                                        {0.15f, 3, -0.9f}, {0.95f, 3, 0.65f}, {0.75f, 1.5f, 0.3f}};

VkShaderModule moduleOf(VkDevice device, const uint32_t* words, size_t bytes) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = bytes;
    info.pCode = words;
    VkShaderModule module = VK_NULL_HANDLE;
    CHECK(vkCreateShaderModule(device, &info, nullptr, &module));
    return module;
}

VkAttachmentDescription attachment(VkFormat format, uint32_t samples, VkAttachmentLoadOp load, VkImageLayout before, VkImageLayout after) {
    VkAttachmentDescription a{};
    a.format = format;
    a.samples = VkSampleCountFlagBits(samples);
    a.loadOp = load;
    a.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    a.initialLayout = before;
    a.finalLayout = after;
    return a;
}

}  // namespace

Room::Room(const Device& device) : device_(device) {
    makePasses();
    room_ = makePipeline(false);
    glass_ = makePipeline(true);
}

Room::~Room() {
    vkDestroyPipeline(device_.device, room_, nullptr);
    vkDestroyPipeline(device_.device, glass_, nullptr);
    vkDestroyPipelineLayout(device_.device, layout_, nullptr);
    vkDestroyRenderPass(device_.device, drawing_, nullptr);
    vkDestroyRenderPass(device_.device, composing_, nullptr);
}

void Room::makePasses() {
    const VkAttachmentReference colour{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference second{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL},
        resolve{2, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    // The room: depth is read by Doppel's compute shader, colour by the next pass.
    const std::array room = {attachment(kColourFormat, kSamples, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_IMAGE_LAYOUT_UNDEFINED,
                                        VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL),
                             attachment(kDepthFormat, kSamples, VK_ATTACHMENT_LOAD_OP_CLEAR, VK_IMAGE_LAYOUT_UNDEFINED,
                                        VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL)};
    VkSubpassDescription subpass{};
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &colour;
    subpass.pDepthStencilAttachment = &second;
    constexpr VkPipelineStageFlags kDepthStages = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    VkSubpassDependency before{VK_SUBPASS_EXTERNAL, 0};  // the frame before reads these images
    before.srcStageMask = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | kDepthStages;
    before.srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    before.dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | kDepthStages;
    before.dstAccessMask =
        VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
    VkSubpassDependency after{0, VK_SUBPASS_EXTERNAL};
    after.srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | kDepthStages;
    after.srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    after.dstStageMask = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    after.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    const std::array dependencies = {before, after};
    VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    info.attachmentCount = uint32_t(room.size());
    info.pAttachments = room.data();
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = uint32_t(dependencies.size());
    info.pDependencies = dependencies.data();
    CHECK(vkCreateRenderPass(device_.device, &info, nullptr, &drawing_));

    // Composing: loads colour and depth, and resolves the colour. Doppel has read the depth in its compute shader before.
    const std::array composed = {
        attachment(kColourFormat, kSamples, VK_ATTACHMENT_LOAD_OP_LOAD, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                   VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL),
        attachment(kDepthFormat, kSamples, VK_ATTACHMENT_LOAD_OP_LOAD, VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL,
                   VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL),
        attachment(kColourFormat, 1, VK_ATTACHMENT_LOAD_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL)};
    subpass.pResolveAttachments = &resolve;
    VkSubpassDependency loaded{VK_SUBPASS_EXTERNAL, 0};
    loaded.srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT |
                          VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | kDepthStages;
    loaded.srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    loaded.dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | kDepthStages;
    loaded.dstAccessMask = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT |
                           VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    VkSubpassDependency copied{0, VK_SUBPASS_EXTERNAL};
    copied.srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    copied.srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    copied.dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT;
    copied.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    const std::array composingDependencies = {loaded, copied};
    info.attachmentCount = uint32_t(composed.size());
    info.pAttachments = composed.data();
    info.dependencyCount = uint32_t(composingDependencies.size());
    info.pDependencies = composingDependencies.data();
    CHECK(vkCreateRenderPass(device_.device, &info, nullptr, &composing_));

    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Push)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &push;
    CHECK(vkCreatePipelineLayout(device_.device, &layout, nullptr, &layout_));
}

VkPipeline Room::makePipeline(bool glass) const {
    VkPipelineShaderStageCreateInfo stages[2]{};
    stages[0].sType = stages[1].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT, stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[0].module = moduleOf(device_.device, room_vert, sizeof room_vert),
    stages[1].module =
        glass ? moduleOf(device_.device, glass_frag, sizeof glass_frag) : moduleOf(device_.device, room_frag, sizeof room_frag);
    stages[0].pName = stages[1].pName = "main";
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VkSampleCountFlagBits(kSamples);
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = VK_TRUE;
    depth.depthWriteEnable = !glass;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;
    VkPipelineColorBlendAttachmentState write{};
    write.colorWriteMask = 0xF;
    write.blendEnable = glass;
    write.srcColorBlendFactor = write.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
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
    info.pVertexInputState = &input;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &colour;
    info.pDynamicState = &dynamic;
    info.layout = layout_;
    info.renderPass = glass ? composing_ : drawing_;
    VkPipeline pipeline = VK_NULL_HANDLE;
    CHECK(vkCreateGraphicsPipelines(device_.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline));
    for (const auto& stage : stages) vkDestroyShaderModule(device_.device, stage.module, nullptr);
    return pipeline;
}

Target Room::makeTarget(VkExtent2D size) const {
    Target target;
    target.size = size;
    target.colour = device_.makeImage(kColourFormat, size, kSamples, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
    target.depth = device_.makeImage(kDepthFormat, size, kSamples, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                                     VK_IMAGE_ASPECT_DEPTH_BIT);
    target.resolved = device_.makeImage(kColourFormat, size, 1, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                                        VK_IMAGE_ASPECT_COLOR_BIT);
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    const VkImageView drawn[] = {target.colour.view, target.depth.view},
                      composed[] = {target.colour.view, target.depth.view, target.resolved.view};
    info.renderPass = drawing_;
    info.attachmentCount = 2;
    info.pAttachments = drawn;
    info.width = size.width, info.height = size.height, info.layers = 1;
    CHECK(vkCreateFramebuffer(device_.device, &info, nullptr, &target.drawing));
    info.renderPass = composing_;
    info.attachmentCount = 3;
    info.pAttachments = composed;
    CHECK(vkCreateFramebuffer(device_.device, &info, nullptr, &target.composing));
    return target;
}

void Room::destroy(Target& target) const {
    vkDestroyFramebuffer(device_.device, target.drawing, nullptr);
    vkDestroyFramebuffer(device_.device, target.composing, nullptr);
    for (Image* image : {&target.colour, &target.depth, &target.resolved}) device_.destroy(*image);
}

void Room::draw(VkCommandBuffer commands, const Target& target, const DplCamera& camera) const {
    VkClearValue clear[2]{};
    clear[0].color = {{0.02f, 0.025f, 0.04f, 1}};
    clear[1].depthStencil.depth = 0;  // infinitely far
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = drawing_;
    begin.framebuffer = target.drawing;
    begin.renderArea.extent = target.size;
    begin.clearValueCount = 2;
    begin.pClearValues = clear;
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    this->begin(commands, target, camera, room_);
    vkCmdDraw(commands, 36, kBoxes, 0, 0);
    vkCmdEndRenderPass(commands);
}

void Room::begin(VkCommandBuffer commands, const Target& target, const DplCamera& camera, VkPipeline pipeline) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    const VkViewport viewport{0, 0, float(target.size.width), float(target.size.height), 0, 1};
    const VkRect2D scissor{{0, 0}, target.size};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    Push push{};
    std::copy(std::begin(camera.viewFromWorld), std::end(camera.viewFromWorld), push.view);
    const float width = float(camera.widthPx), height = float(camera.heightPx);
    push.lens[0] = 2 * camera.fx / width, push.lens[1] = 2 * camera.fy / height;
    push.lens[2] = 2 * camera.cx / width - 1, push.lens[3] = 2 * camera.cy / height - 1;
    push.near = kNearM;
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof push, &push);
}

void Room::drawGlass(VkCommandBuffer commands, const Target& target, const DplCamera& camera) const {
    begin(commands, target, camera, glass_);
    vkCmdDraw(commands, 6, 1, kGlassFrontVertex, kBoxes);
}

void Room::beginComposing(VkCommandBuffer commands, const Target& target) const {
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = composing_;
    begin.framebuffer = target.composing;
    begin.renderArea.extent = target.size;
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
}

void Room::endComposing(VkCommandBuffer commands) const {
    vkCmdEndRenderPass(commands);
}

namespace {

constexpr float kPlaces[4][2] = {{0.375f, 0.125f}, {0.875f, 0.375f}, {0.125f, 0.625f}, {0.625f, 0.875f}};  // Vulkan's standard locations

/** View z of the nearest box from `first` on, along the ray through a point of the picture; infinite: none. */
float nearestBoxM(const DplCamera& camera, float xPx, float yPx, uint32_t first, uint32_t end) {
    const float* m = camera.viewFromWorld;
    const float ray[3] = {(xPx - camera.cx) / camera.fx, (yPx - camera.cy) / camera.fy, 1};
    float eye[3], direction[3];  // in the world; the direction has view z 1
    for (int i = 0; i < 3; ++i) {
        eye[i] = -(m[i] * m[3] + m[4 + i] * m[7] + m[8 + i] * m[11]);
        direction[i] = m[i] * ray[0] + m[4 + i] * ray[1] + m[8 + i] * ray[2];
    }
    float nearest = INFINITY;
    for (uint32_t box = first; box < end; ++box) {
        float enter = kNearM, leave = INFINITY;
        for (int i = 0; i < 3; ++i) {
            const float a = (kLow[box][i] - eye[i]) / direction[i], b = (kHigh[box][i] - eye[i]) / direction[i];
            enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
        }
        if (enter <= leave) nearest = std::min(nearest, enter);
    }
    return nearest;
}

}  // namespace

float roomDepthM(const DplCamera& camera, uint32_t x, uint32_t y) {
    float farthest = 0;
    for (const auto& place : kPlaces)
        farthest = std::max(farthest, nearestBoxM(camera, float(x) + place[0], float(y) + place[1], 0, kBoxes));
    return std::isinf(farthest) ? 0 : farthest;
}

int glassSamples(const DplCamera& camera, uint32_t x, uint32_t y, float nearestM) {
    int shown = 0;
    for (const auto& place : kPlaces) {
        const float px = float(x) + place[0], py = float(y) + place[1];
        const float glassM = nearestBoxM(camera, px, py, kBoxes, kBoxes + 1), roomM = nearestBoxM(camera, px, py, 0, kBoxes);
        shown += glassM < roomM && (nearestM == 0 || glassM < nearestM);
    }
    return shown;
}
