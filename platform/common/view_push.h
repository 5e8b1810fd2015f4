// SPDX-License-Identifier: Apache-2.0
// What the shells' own drawings of triangles share: push constants by which the world is projected into the image of one view, or of both.
#pragma once

#include <doppel/doppel.h>

#include <algorithm>

#include "platform/common/vulkan_help.h"

namespace dpl::platform {

/** Stored depth = kRoomNearM / view z, 0 infinitely far: scale 0 and offset kRoomNearM of DplVulkanSceneDepth. */
constexpr float kRoomNearM = 0.05f;

struct ViewPush {
    float clipFromWorld[2][16];  // column by column
};
static_assert(sizeof(ViewPush) <= 128);  // what every device has

/** clip = (2 fx/w x + (2 cx/w - 1) z, 2 fy/h y + (2 cy/h - 1) z, near, z) of view coordinates; Vulkan's y points down as the camera's. */
inline ViewPush viewPush(const DplCamera* views, uint32_t viewCount) {
    ViewPush push{};
    for (uint32_t i = 0; i < std::min(viewCount, 2u); ++i) {
        const DplCamera& view = views[i];
        float* columns = push.clipFromWorld[i];
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
    return push;
}

/** Triangles without indices. The layout has a ViewPush for the vertex shader. */
struct DrawnTriangles {
    VkPipeline pipeline = VK_NULL_HANDLE;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkBuffer vertices = VK_NULL_HANDLE;
    uint32_t vertexCount = 0;
};
/** Records them as one view sees them, or both. */
inline void recordTriangles(VkCommandBuffer commands, VkExtent2D extent, const DrawnTriangles& drawn, const DplCamera* views,
                            uint32_t viewCount) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, drawn.pipeline);
    const VkViewport viewport{0, 0, float(extent.width), float(extent.height), 0, 1};
    const VkRect2D scissor{{0, 0}, extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    const ViewPush push = viewPush(views, viewCount);
    vkCmdPushConstants(commands, drawn.layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof push, &push);
    const VkDeviceSize start = 0;
    vkCmdBindVertexBuffers(commands, 0, 1, &drawn.vertices, &start);
    vkCmdDraw(commands, drawn.vertexCount, 1, 0, 0);
}

}  // namespace dpl::platform
