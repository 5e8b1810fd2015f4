// SPDX-License-Identifier: Apache-2.0
#include "platform/common/floor_shadow.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "floor_shadow_frag.h"
#include "floor_shadow_vert.h"
#include "floor_shadow_vert_multiview.h"
#include "platform/common/view_push.h"

namespace dpl::platform {

constexpr float kLiftM = 0.002f;

void appendShadow(const doppel::ContactShadow& s, std::vector<ShadowVertex>& to) {
    constexpr uint32_t n = DPL_CONTACT_SHADOW_PX;
    const float *u = s.across, *v = s.along;
    float up[3] = {v[1] * u[2] - v[2] * u[1], v[2] * u[0] - v[0] * u[2], v[0] * u[1] - v[1] * u[0]};
    const float length = std::sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]);
    const auto corner = [&](uint32_t x, uint32_t y) {
        ShadowVertex vertex{{}, kShadowStrength * float(s.alpha[size_t(y) * n + x]) / 255};
        for (int axis = 0; axis < 3; ++axis)
            vertex.position[axis] =
                s.corner[axis] + (float(x) + 0.5f) / n * u[axis] + (float(y) + 0.5f) / n * v[axis] + kLiftM / length * up[axis];
        return vertex;
    };
    for (uint32_t y = 0; y + 1 < n && s.darkest > 0; ++y)
        for (uint32_t x = 0; x + 1 < n; ++x) {
            const uint8_t *row = &s.alpha[size_t(y) * n + x], *next = row + n;
            if (row[0] == 0 && row[1] == 0 && next[0] == 0 && next[1] == 0) continue;
            for (const auto& [dx, dy] : {std::pair(0u, 0u), {0u, 1u}, {1u, 0u}, {1u, 0u}, {0u, 1u}, {1u, 1u}})
                to.push_back(corner(x + dx, y + dy));
        }
}

Result<std::unique_ptr<FloorShadows>> FloorShadows::create(const VulkanHandles& on, const RoomPass& pass, uint32_t mostShadows,
                                                           bool withDepth) {
    std::unique_ptr<FloorShadows> made(new FloorShadows(on, mostShadows));
    const VkPushConstantRange push{VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(ViewPush)};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &push;
    DPL_VK_MAKE(made->layout_, vkCreatePipelineLayout, on.device, layout);
    const VkVertexInputBindingDescription binding{0, sizeof(ShadowVertex), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attribute{0, 0, VK_FORMAT_R32G32B32A32_SFLOAT, 0};
    TriangleDrawing drawing;
    drawing.layout = made->layout_;
    drawing.pass = pass.renderPass, drawing.subpass = pass.subpass, drawing.samples = pass.samples;
    drawing.vertexShader = floor_shadow_vert, drawing.fragmentShader = floor_shadow_frag;
    if (pass.viewMask) drawing.vertexShader = floor_shadow_vert_multiview;
    drawing.input.vertexBindingDescriptionCount = 1;
    drawing.input.pVertexBindingDescriptions = &binding;
    drawing.input.vertexAttributeDescriptionCount = 1;
    drawing.input.pVertexAttributeDescriptions = &attribute;
    if (withDepth) drawing.depth = VK_COMPARE_OP_GREATER;
    drawing.over = true;
    DPL_SHELL_TRY(made->pipeline_, makePipeline(on.device, drawing));
    const VkDeviceSize bytes = mostShadows * kMostShadowVertices * sizeof(ShadowVertex);
    for (HostBuffer& buffer : made->vertices_) {
        DPL_SHELL_TRY(buffer, makeHostBuffer(on, bytes, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT));
    }
    return made;
}

FloorShadows::~FloorShadows() {
    vkDestroyPipeline(on_.device, pipeline_, nullptr);
    vkDestroyPipelineLayout(on_.device, layout_, nullptr);
    for (HostBuffer& buffer : vertices_) destroyHostBuffer(on_, buffer);
}

void FloorShadows::set(uint32_t slot, std::span<const doppel::ContactShadow> shadows) {
    made_.clear();
    for (const doppel::ContactShadow& shadow : shadows.first(std::min<size_t>(shadows.size(), mostShadows_))) appendShadow(shadow, made_);
    if (!made_.empty()) std::memcpy(vertices_[slot].mapped, made_.data(), made_.size() * sizeof(ShadowVertex));
    vertexCount_[slot] = uint32_t(made_.size());
}

void FloorShadows::record(VkCommandBuffer commands, VkExtent2D extent, const DplCamera* views, uint32_t viewCount, uint32_t slot) const {
    if (vertexCount_[slot] == 0) return;
    recordTriangles(commands, extent, {pipeline_, layout_, vertices_[slot].buffer, vertexCount_[slot]}, views, viewCount);
}

}  // namespace dpl::platform
