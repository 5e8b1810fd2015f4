// SPDX-License-Identifier: Apache-2.0
// What the frames in flight of a shell use: one set for each slot of doppel_vulkan.h.
#pragma once

#include "platform/common/device.h"

namespace dpl::platform {

/** What one frame in flight uses. */
struct FrameSlot {
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence done = VK_NULL_HANDLE;
    VkSemaphore imageReady = VK_NULL_HANDLE;
};

/** Command buffers, fences and semaphores of the slots. */
struct FrameSlots {
    /** The device must live longer. */
    static Result<std::unique_ptr<FrameSlots>> create(Device& device) {
        std::unique_ptr<FrameSlots> made(new FrameSlots(device));
        VkCommandPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        poolInfo.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
        poolInfo.queueFamilyIndex = device.family();
        DPL_VK_MAKE(made->pool, vkCreateCommandPool, device.device(), poolInfo);
        for (FrameSlot& slot : made->all) {
            VkCommandBufferAllocateInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
            buffer.commandPool = made->pool;
            buffer.commandBufferCount = 1;
            DPL_VK(vkAllocateCommandBuffers(device.device(), &buffer, &slot.commands));
            VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
            fence.flags = VK_FENCE_CREATE_SIGNALED_BIT;
            DPL_VK_MAKE(slot.done, vkCreateFence, device.device(), fence);
            const VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
            DPL_VK_MAKE(slot.imageReady, vkCreateSemaphore, device.device(), semaphore);
        }
        return made;
    }
    ~FrameSlots() {
        for (const FrameSlot& slot : all) {
            vkDestroyFence(device.device(), slot.done, nullptr);
            vkDestroySemaphore(device.device(), slot.imageReady, nullptr);
        }
        vkDestroyCommandPool(device.device(), pool, nullptr);
    }
    FrameSlots(const FrameSlots&) = delete;
    FrameSlots& operator=(const FrameSlots&) = delete;

    Device& device;
    VkCommandPool pool = VK_NULL_HANDLE;
    FrameSlot all[DPL_VULKAN_SLOTS];

private:
    explicit FrameSlots(Device& d) : device(d) {}
};

}  // namespace dpl::platform
