// SPDX-License-Identifier: Apache-2.0
// The caller's Vulkan device, as the mock uses it: swapchain images are made on it and read on its queue. The functions come from the
// caller's own vkGetInstanceProcAddr, so that a validation layer sees every call.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <vector>

namespace dpl::mockxr {

#define DPL_MOCKXR_DEVICE(DO) DO(vkGetPhysicalDeviceMemoryProperties) DO(vkGetDeviceQueue) DO(vkQueueSubmit)
#define DPL_MOCKXR_IMAGE(DO) DO(vkCreateImage) DO(vkDestroyImage) DO(vkGetImageMemoryRequirements) DO(vkBindImageMemory)
#define DPL_MOCKXR_BUFFER(DO) DO(vkCreateBuffer) DO(vkDestroyBuffer) DO(vkGetBufferMemoryRequirements) DO(vkBindBufferMemory)
#define DPL_MOCKXR_MEMORY(DO) DO(vkAllocateMemory) DO(vkFreeMemory) DO(vkMapMemory)
#define DPL_MOCKXR_POOL(DO) DO(vkCreateCommandPool) DO(vkDestroyCommandPool) DO(vkAllocateCommandBuffers)
#define DPL_MOCKXR_FENCE(DO) DO(vkCreateFence) DO(vkDestroyFence) DO(vkResetFences) DO(vkWaitForFences)
#define DPL_MOCKXR_RECORD(DO) DO(vkBeginCommandBuffer) DO(vkEndCommandBuffer) DO(vkCmdPipelineBarrier)
#define DPL_MOCKXR_COPY(DO) DO(vkCmdCopyImageToBuffer) DO(vkCmdClearColorImage) DO(vkCmdClearDepthStencilImage)
#define DPL_MOCKXR_FIRST(DO) DPL_MOCKXR_DEVICE(DO) DPL_MOCKXR_IMAGE(DO) DPL_MOCKXR_BUFFER(DO) DPL_MOCKXR_MEMORY(DO)
#define DPL_MOCKXR_VULKAN(DO) DPL_MOCKXR_FIRST(DO) DPL_MOCKXR_POOL(DO) DPL_MOCKXR_FENCE(DO) DPL_MOCKXR_RECORD(DO) DPL_MOCKXR_COPY(DO)

class VulkanCalls {
public:
    /** Takes the queue and makes a command buffer. False: a call failed. */
    bool open(PFN_vkGetInstanceProcAddr proc, VkInstance instance, VkPhysicalDevice physicalDevice, VkDevice device, uint32_t family,
              uint32_t queue);
    void close();

    /** False: the driver cannot. The image is in its attachment layout afterwards. */
    bool makeImage(const VkImageCreateInfo& info, VkImage& image, VkDeviceMemory& memory);
    void destroyImage(VkImage image, VkDeviceMemory memory);

    struct Copy {
        VkImage image;
        VkFormat format;
        uint32_t layer;
        VkRect2D rect;
        std::vector<uint8_t> bytes;  // what was read
    };
    /** Reads parts of images that are in their attachment layouts, waits, and fills each whole image with other values. */
    bool read(std::vector<Copy>& copies);

    static bool isDepth(VkFormat format);
    static uint32_t bytesPerPixel(VkFormat format);  // as a copy writes the colour or depth aspect; 0: unknown

private:
    bool begin();
    bool submit();
    void barrier(VkImage image, VkFormat format, VkImageLayout from, VkImageLayout to);
    bool reserve(VkDeviceSize bytes);
    int memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted) const;

#define DPL_MOCKXR_MEMBER(name) PFN_##name name = nullptr;
    DPL_MOCKXR_VULKAN(DPL_MOCKXR_MEMBER)
#undef DPL_MOCKXR_MEMBER
    VkPhysicalDevice physicalDevice_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    VkBuffer buffer_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    VkDeviceSize reserved_ = 0;
    uint8_t* mapped_ = nullptr;
};

}  // namespace dpl::mockxr
