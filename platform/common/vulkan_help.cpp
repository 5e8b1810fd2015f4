// SPDX-License-Identifier: Apache-2.0
#include "platform/common/vulkan_help.h"

#include <algorithm>

namespace dpl::platform {
namespace {

const char* nameOf(VkResult code) {
    switch (code) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
            return "out of memory";
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            return "out of graphics memory";
        case VK_ERROR_DEVICE_LOST:
            return "the graphics device was lost";
        case VK_ERROR_SURFACE_LOST_KHR:
            return "the window's surface was lost";
        case VK_ERROR_INCOMPATIBLE_DRIVER:
            return "no Vulkan driver is installed";
        default:
            return nullptr;
    }
}

}  // namespace

VulkanError::VulkanError(VkResult result, const std::string& call)
    : std::runtime_error(std::string(nameOf(result) ? nameOf(result) : "Vulkan failed with code " + std::to_string(int(result))) + " (" +
                         call.substr(0, call.find('(')) + ")"),
      code(result) {}

void checkVulkan(VkResult result, const char* call) {
    if (result != VK_SUCCESS) throw VulkanError(result, call);
}

uint32_t memoryTypeOf(VkPhysicalDevice physical, uint32_t allowed, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(physical, &memory);
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
        if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
    throw std::runtime_error("the graphics device has no memory of the kind that is needed");
}

Image makeImage(const VulkanHandles& on, VkFormat format, VkExtent2D size, uint32_t layers, uint32_t samples, VkImageUsageFlags usage,
                VkImageAspectFlags aspect) {
    Image made;
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {size.width, size.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = std::max(1u, layers);
    info.samples = VkSampleCountFlagBits(samples);
    info.usage = usage;
    DPL_VK(vkCreateImage(on.device, &info, nullptr, &made.image));
    VkMemoryRequirements needs{};
    vkGetImageMemoryRequirements(on.device, made.image, &needs);
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex = memoryTypeOf(on.physical, needs.memoryTypeBits, 0);
    DPL_VK(vkAllocateMemory(on.device, &allocation, nullptr, &made.memory));
    DPL_VK(vkBindImageMemory(on.device, made.image, made.memory, 0));
    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = made.image;
    view.viewType = layers > 0 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    view.format = format;
    view.subresourceRange = {aspect, 0, 1, 0, info.arrayLayers};
    DPL_VK(vkCreateImageView(on.device, &view, nullptr, &made.view));
    return made;
}

void destroyImage(const VulkanHandles& on, Image& image) {
    vkDestroyImageView(on.device, image.view, nullptr);
    vkDestroyImage(on.device, image.image, nullptr);
    vkFreeMemory(on.device, image.memory, nullptr);
    image = {};
}

HostBuffer makeHostBuffer(const VulkanHandles& on, VkDeviceSize bytes, VkBufferUsageFlags usage) {
    HostBuffer made;
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = usage;
    DPL_VK(vkCreateBuffer(on.device, &info, nullptr, &made.buffer));
    VkMemoryRequirements needs{};
    vkGetBufferMemoryRequirements(on.device, made.buffer, &needs);
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex =
        memoryTypeOf(on.physical, needs.memoryTypeBits, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    DPL_VK(vkAllocateMemory(on.device, &allocation, nullptr, &made.memory));
    DPL_VK(vkBindBufferMemory(on.device, made.buffer, made.memory, 0));
    DPL_VK(vkMapMemory(on.device, made.memory, 0, VK_WHOLE_SIZE, 0, &made.mapped));
    return made;
}

void destroyHostBuffer(const VulkanHandles& on, HostBuffer& buffer) {
    vkDestroyBuffer(on.device, buffer.buffer, nullptr);
    vkFreeMemory(on.device, buffer.memory, nullptr);  // unmaps it too
    buffer = {};
}

VkShaderModule makeShaderModule(VkDevice device, const uint32_t* words, size_t bytes) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = bytes;
    info.pCode = words;
    VkShaderModule module = VK_NULL_HANDLE;
    DPL_VK(vkCreateShaderModule(device, &info, nullptr, &module));
    return module;
}

}  // namespace dpl::platform
