// SPDX-License-Identifier: Apache-2.0
// The program's Vulkan device, with what it needs to make images, buffers and command buffers.
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

void check(VkResult result, const char* call);
#define CHECK(call) check(call, #call)

struct Image {
    VkImage image = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
};

struct Device {
    Device();
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    Image makeImage(VkFormat format, VkExtent2D size, uint32_t samples, VkImageUsageFlags usage, VkImageAspectFlags aspect) const;
    void destroy(Image& image) const;
    uint32_t memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted) const;

    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t family = 0;
    VkPhysicalDeviceFeatures2 enabled{};
    std::string name;
    std::vector<std::string> complaints;  // of the validation layer, if it is installed

private:
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
};
