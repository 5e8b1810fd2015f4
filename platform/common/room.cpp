// SPDX-License-Identifier: Apache-2.0
#include "platform/common/room.h"

#include <cstddef>
#include <cstring>

#include "platform/common/view_push.h"
#include "room_frag.h"
#include "room_vert.h"
#include "room_vert_multiview.h"

namespace dpl::platform {

Result<std::unique_ptr<Room>> Room::create(const VulkanHandles& on, const RoomPass& pass) {
    std::unique_ptr<Room> made(new Room(on));
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(ViewPush)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &push;
    DPL_VK_MAKE(made->layout_, vkCreatePipelineLayout, on.device, layout);
    for (const RoomLight light : {RoomLight::Dark, RoomLight::Bright}) {
        DPL_SHELL_TRY(made->pipelines_[int(light)], made->makePipeline(pass, light));
    }
    DPL_SHELL_TRY(made->vertices_, makeHostBuffer(on, maxRoomVertices() * sizeof(RoomVertex), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT));
    made->build({});
    return made;
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

Result<VkPipeline> Room::makePipeline(const RoomPass& pass, RoomLight light) const {
    const VkBool32 bright = light == RoomLight::Bright;
    const VkSpecializationMapEntry entry{0, 0, sizeof bright};
    const VkSpecializationInfo special{1, &entry, sizeof bright, &bright};
    const VkVertexInputBindingDescription binding{0, sizeof(RoomVertex), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(RoomVertex, position)},
                                                            {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(RoomVertex, normal)},
                                                            {2, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(RoomVertex, surface)}};
    TriangleDrawing drawing;
    drawing.layout = layout_;
    drawing.pass = pass.renderPass, drawing.subpass = pass.subpass, drawing.samples = pass.samples;
    drawing.vertexShader = room_vert, drawing.fragmentShader = room_frag;
    if (pass.viewMask) drawing.vertexShader = room_vert_multiview;
    drawing.special = &special;
    drawing.input.vertexBindingDescriptionCount = 1;
    drawing.input.pVertexBindingDescriptions = &binding;
    drawing.input.vertexAttributeDescriptionCount = 3;
    drawing.input.pVertexAttributeDescriptions = attributes;
    drawing.frontOnly = true;
    drawing.depth = VK_COMPARE_OP_GREATER;
    return platform::makePipeline(on_.device, drawing);
}

void Room::record(VkCommandBuffer commands, VkExtent2D extent, const DplCamera* views, uint32_t viewCount, RoomLight light) const {
    recordTriangles(commands, extent, {pipelines_[int(light)], layout_, vertices_.buffer, vertexCount_}, views, viewCount);
}

}  // namespace dpl::platform
