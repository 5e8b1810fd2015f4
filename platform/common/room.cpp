// SPDX-License-Identifier: Apache-2.0
#include "platform/common/room.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "room_frag.h"
#include "room_vert.h"
#include "room_vert_multiview.h"

namespace dpl::platform {
namespace {

struct Push {
    float clipFromWorld[2][16];  // column by column
};
static_assert(sizeof(Push) <= 128);  // what every device has

/** clip = (2 fx/w x + (2 cx/w - 1) z, 2 fy/h y + (2 cy/h - 1) z, near, z) of view coordinates; Vulkan's y points down as the camera's. */
void writeClipFromWorld(const DplCamera& view, float* columns) {
    const float* v = view.viewFromWorld;
    const float width = float(view.widthPx), height = float(view.heightPx);
    const float sx = 2 * view.fx / width, ox = 2 * view.cx / width - 1, sy = 2 * view.fy / height, oy = 2 * view.cy / height - 1;
    for (int c = 0; c < 4; ++c) {
        columns[4 * c] = sx * v[c] + ox * v[8 + c];
        columns[4 * c + 1] = sy * v[4 + c] + oy * v[8 + c];
        columns[4 * c + 2] = c == 3 ? kRoomNearM : 0;
        columns[4 * c + 3] = v[8 + c];
    }
}

}  // namespace

Room::Room(const VulkanHandles& on, const RoomPass& pass) : on_(on) {
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Push)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &push;
    DPL_VK(vkCreatePipelineLayout(on.device, &layout, nullptr, &layout_));
    for (const RoomLight light : {RoomLight::Dark, RoomLight::Bright}) pipelines_[int(light)] = makePipeline(pass, light);
    vertices_ = makeHostBuffer(on, maxRoomVertices() * sizeof(RoomVertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    build({});
}

Room::~Room() {
    for (VkPipeline pipeline : pipelines_) vkDestroyPipeline(on_.device, pipeline, nullptr);
    vkDestroyPipelineLayout(on_.device, layout_, nullptr);
    destroyHostBuffer(on_, vertices_);
}

void Room::build(const RoomPlan& plan) {
    const std::vector<RoomVertex> mesh = roomMesh(plan);
    std::memcpy(vertices_.mapped, mesh.data(), mesh.size() * sizeof(RoomVertex));
    vertexCount_ = uint32_t(mesh.size());
}

VkPipeline Room::makePipeline(const RoomPass& pass, RoomLight light) const {
    const VkBool32 bright = light == RoomLight::Bright;
    const VkSpecializationMapEntry entry{0, 0, sizeof bright};
    const VkSpecializationInfo special{1, &entry, sizeof bright, &bright};
    VkPipelineShaderStageCreateInfo stages[2]{};
    stages[0].sType = stages[1].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT, stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    stages[0].module = pass.viewMask ? makeShaderModule(on_.device, room_vert_multiview, sizeof room_vert_multiview)
                                     : makeShaderModule(on_.device, room_vert, sizeof room_vert);
    stages[1].module = makeShaderModule(on_.device, room_frag, sizeof room_frag);
    stages[1].pSpecializationInfo = &special;
    stages[0].pName = stages[1].pName = "main";
    const VkVertexInputBindingDescription binding{0, sizeof(RoomVertex), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(RoomVertex, position)},
                                                            {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(RoomVertex, normal)},
                                                            {2, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(RoomVertex, surface)}};
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    input.vertexBindingDescriptionCount = 1;
    input.pVertexBindingDescriptions = &binding;
    input.vertexAttributeDescriptionCount = 3;
    input.pVertexAttributeDescriptions = attributes;
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewport.viewportCount = viewport.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.cullMode = VK_CULL_MODE_BACK_BIT;
    raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VkSampleCountFlagBits(pass.samples);
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;
    VkPipelineColorBlendAttachmentState write{};
    write.colorWriteMask = 0xF;
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
    info.renderPass = pass.renderPass;
    info.subpass = pass.subpass;
    VkPipeline pipeline = VK_NULL_HANDLE;
    const VkResult made = vkCreateGraphicsPipelines(on_.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
    for (const auto& stage : stages) vkDestroyShaderModule(on_.device, stage.module, nullptr);
    checkVulkan(made, "vkCreateGraphicsPipelines");
    return pipeline;
}

void Room::record(VkCommandBuffer commands, VkExtent2D extent, const DplCamera* views, uint32_t viewCount, RoomLight light) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_[int(light)]);
    const VkViewport viewport{0, 0, float(extent.width), float(extent.height), 0, 1};
    const VkRect2D scissor{{0, 0}, extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    Push push{};
    for (uint32_t v = 0; v < std::min(viewCount, 2u); ++v) writeClipFromWorld(views[v], push.clipFromWorld[v]);
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof push, &push);
    const VkDeviceSize start = 0;
    vkCmdBindVertexBuffers(commands, 0, 1, &vertices_.buffer, &start);
    vkCmdDraw(commands, vertexCount_, 1, 0, 0);
}

}  // namespace dpl::platform
