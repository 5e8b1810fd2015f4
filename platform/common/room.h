// SPDX-License-Identifier: Apache-2.0
// A room for avatars to stand in, drawn inside a render pass of the shell. Colours are linear light; depth is reversed and infinite.
//
//   auto room = Room::create({physical, device}, {renderPass, 0, 4, 0});
//   (*room)->build({floorY, stands});
//   each frame, inside the render pass:  (*room)->record(commands, extent, &view, 1, RoomLight::Dark);
#pragma once

#include <doppel/doppel.h>

#include <memory>

#include "platform/common/room_mesh.h"
#include "platform/common/view_push.h"
#include "platform/common/vulkan_help.h"

namespace dpl::platform {

/** The pass that the room is drawn in. Colour: RGBA16F or an SRGB format, cleared to anything, because the backdrop covers all that lies
 *  within 16 m. Depth: cleared to 0; a float format keeps what is far exact. */
struct RoomPass {
    VkRenderPass renderPass = VK_NULL_HANDLE;
    uint32_t subpass = 0, samples = 1;
    uint32_t viewMask = 0;  // 0: one view a recording; 3: both views of a multiview pass
};

class Room {
public:
    /** Makes two pipelines; submits nothing. The device must outlive the room. */
    static Result<std::unique_ptr<Room>> create(const VulkanHandles& on, const RoomPass& pass);
    ~Room();
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;

    /** Makes the triangles. Only while no submitted commands that draw the room can still run. */
    void build(const RoomPlan& plan);

    /** Records one draw. views: one, or two in a pass with a view mask; their image sizes are not read beyond the shape of the frustum.
     *  Sets pipeline, vertex buffer 0, push constants, viewport and scissor. */
    void record(VkCommandBuffer commands, VkExtent2D extent, const DplCamera* views, uint32_t viewCount, RoomLight light) const;

private:
    explicit Room(const VulkanHandles& on) : on_(on) {}
    Result<VkPipeline> makePipeline(const RoomPass& pass, RoomLight light) const;

    VulkanHandles on_;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipelines_[2] = {};
    HostBuffer vertices_;
    uint32_t vertexCount_ = 0;
};

}  // namespace dpl::platform
