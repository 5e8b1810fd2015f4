// SPDX-License-Identifier: Apache-2.0
// Contact shadows, drawn onto the floor of a shell's picture: after what stands there, before the avatars.
//
//   auto shadows = FloorShadows::create({physical, device}, pass, 16);
//   each frame:  (*shadows)->set(slot, contactShadows);  ... inside the render pass: (*shadows)->record(commands, extent, &view, 1, slot);
#pragma once

#include <doppel/doppel_vulkan.h>

#include <doppel/doppel.hpp>
#include <memory>
#include <span>

#include "platform/common/room.h"

namespace dpl::platform {

/** Part of the light on a floor that comes evenly from above and that a contact shadow may take. */
constexpr float kShadowStrength = 0.7f;

/** A triangle's corner: world, metres, and alpha. */
struct ShadowVertex {
    float position[3], alpha;
};
/** The triangles of a shadow, without those where alpha is 0. They lie 2 mm above its floor, so that the floor's own depth does not hide
 *  them. At most kMostShadowVertices. */
void appendShadow(const doppel::ContactShadow& shadow, std::vector<ShadowVertex>& to);
constexpr size_t kMostShadowVertices = size_t(6) * (DPL_CONTACT_SHADOW_PX - 1) * (DPL_CONTACT_SHADOW_PX - 1);

class FloorShadows {
public:
    /** Makes a pipeline; submits nothing. The device must outlive it. withDepth: the pass has the room's depth, which hides shadows. */
    static Result<std::unique_ptr<FloorShadows>> create(const VulkanHandles& on, const RoomPass& pass, uint32_t mostShadows,
                                                        bool withDepth = true);
    ~FloorShadows();
    FloorShadows(const FloorShadows&) = delete;
    FloorShadows& operator=(const FloorShadows&) = delete;

    /** What the next recording of a frame slot draws; shadows beyond mostShadows are left out. Only while no submitted commands of the slot
     * can still run. */
    void set(uint32_t slot, std::span<const doppel::ContactShadow> shadows);
    /** As Room::record. Records nothing if there are no shadows. */
    void record(VkCommandBuffer commands, VkExtent2D extent, const DplCamera* views, uint32_t viewCount, uint32_t slot) const;

private:
    FloorShadows(const VulkanHandles& on, uint32_t mostShadows) : on_(on), mostShadows_(mostShadows) {}

    VulkanHandles on_;
    uint32_t mostShadows_ = 0;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
    HostBuffer vertices_[DPL_VULKAN_SLOTS];
    uint32_t vertexCount_[DPL_VULKAN_SLOTS] = {};
    std::vector<ShadowVertex> made_;
};

}  // namespace dpl::platform
