// SPDX-License-Identifier: Apache-2.0
// Instance, device and queue: made once, torn down in order.
#pragma once

#include <vulkan/vulkan.h>

#include "sdk/backend/vulkan/vulkan_backend.h"

namespace dpl::vk {

Error failVk(const char* what, VkResult result);

// DPL_VK(call): return the error of a failed Vulkan call from the calling function.
#define DPL_VK(...) \
    if (const VkResult dplVkResult = (__VA_ARGS__); dplVkResult != VK_SUCCESS) return dpl::vk::failVk(#__VA_ARGS__, dplVkResult)

struct Device {
    VkInstance instance = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t queueFamily = 0;
    VkPhysicalDeviceMemoryProperties memory{};
    double nanosecondsPerTick = 0;
    uint32_t timestampBits = 0;
    VkFormat depthSumFormat = VK_FORMAT_R32G32_SFLOAT;
    DeviceInfo info;
    std::shared_ptr<std::atomic<uint32_t>> validationMessages;

    Device() = default;
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    ~Device();
};

Result<std::unique_ptr<Device>> openDevice(const VulkanOptions& options);

}  // namespace dpl::vk
