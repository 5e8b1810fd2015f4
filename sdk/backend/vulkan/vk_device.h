// SPDX-License-Identifier: Apache-2.0
// Opens the Vulkan instance, device and queue that a backend uses until it is destroyed.
#pragma once

#include "sdk/backend/vulkan/vk_functions.h"
#include "sdk/backend/vulkan/vulkan_test_options.h"

namespace dpl::vk {

/** The error of a failed Vulkan call. `what`: the text of the call, which contains the function's name, or that name alone. */
Error failVk(std::string_view what, VkResult result);

// DPL_VK(call): if the Vulkan call fails, return its error from the calling function.
#define DPL_VK(...) \
    if (const VkResult dplVkResult = (__VA_ARGS__); dplVkResult != VK_SUCCESS) return dpl::vk::failVk(#__VA_ARGS__, dplVkResult)

struct Device {
    Functions vk;
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

/** Code::Unsupported when there is no loader, no driver or no device that fits; Code::NotFound when the validation layer is missing. */
Result<std::unique_ptr<Device>> openDevice(const VulkanTestOptions& options);

}  // namespace dpl::vk
