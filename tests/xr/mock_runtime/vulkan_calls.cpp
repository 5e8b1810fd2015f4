// SPDX-License-Identifier: Apache-2.0
#include "tests/xr/mock_runtime/vulkan_calls.h"

#include <cstring>

namespace dpl::mockxr {

bool VulkanCalls::isDepth(VkFormat format) {
    return format == VK_FORMAT_D16_UNORM || format == VK_FORMAT_X8_D24_UNORM_PACK32 || format == VK_FORMAT_D32_SFLOAT ||
           format == VK_FORMAT_D24_UNORM_S8_UINT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
}

uint32_t VulkanCalls::bytesPerPixel(VkFormat format) {
    switch (format) {
        case VK_FORMAT_R8G8B8A8_UNORM:
        case VK_FORMAT_R8G8B8A8_SRGB:
        case VK_FORMAT_B8G8R8A8_UNORM:
        case VK_FORMAT_B8G8R8A8_SRGB:
        case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
            return 4;
        case VK_FORMAT_R16G16B16A16_SFLOAT:
            return 8;
        case VK_FORMAT_D16_UNORM:
            return 2;
        default:
            return isDepth(format) ? 4 : 0;
    }
}

bool VulkanCalls::open(PFN_vkGetInstanceProcAddr proc, VkInstance instance, VkPhysicalDevice physicalDevice, VkDevice device,
                       uint32_t family, uint32_t queue) {
#define DPL_MOCKXR_LOAD(name)                                   \
    name = reinterpret_cast<PFN_##name>(proc(instance, #name)); \
    if (!name) return false;
    DPL_MOCKXR_VULKAN(DPL_MOCKXR_LOAD)
#undef DPL_MOCKXR_LOAD
    physicalDevice_ = physicalDevice, device_ = device;
    vkGetDeviceQueue(device, family, queue, &queue_);
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = family;
    if (vkCreateCommandPool(device_, &pool, nullptr, &pool_) != VK_SUCCESS) return false;
    VkCommandBufferAllocateInfo buffers{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    buffers.commandPool = pool_;
    buffers.commandBufferCount = 1;
    const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    return vkAllocateCommandBuffers(device_, &buffers, &commands_) == VK_SUCCESS &&
           vkCreateFence(device_, &fence, nullptr, &fence_) == VK_SUCCESS;
}

void VulkanCalls::close() {
    if (!device_) return;
    vkDestroyBuffer(device_, buffer_, nullptr);
    vkFreeMemory(device_, memory_, nullptr);
    vkDestroyFence(device_, fence_, nullptr);
    vkDestroyCommandPool(device_, pool_, nullptr);
    device_ = VK_NULL_HANDLE;
}

int VulkanCalls::memoryType(uint32_t allowed, VkMemoryPropertyFlags wanted) const {
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(physicalDevice_, &memory);
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
        if ((allowed >> i & 1) && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return int(i);
    return -1;
}

bool VulkanCalls::makeImage(const VkImageCreateInfo& info, VkImage& image, VkDeviceMemory& memory) {
    if (vkCreateImage(device_, &info, nullptr, &image) != VK_SUCCESS) return false;
    VkMemoryRequirements needs{};
    vkGetImageMemoryRequirements(device_, image, &needs);
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    const int type = memoryType(needs.memoryTypeBits, 0);
    allocation.memoryTypeIndex = uint32_t(type);
    if (type < 0 || vkAllocateMemory(device_, &allocation, nullptr, &memory) != VK_SUCCESS ||
        vkBindImageMemory(device_, image, memory, 0) != VK_SUCCESS || !begin())
        return false;
    barrier(image, info.format, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_MAX_ENUM);
    return submit();
}

void VulkanCalls::destroyImage(VkImage image, VkDeviceMemory memory) {
    vkDestroyImage(device_, image, nullptr);
    vkFreeMemory(device_, memory, nullptr);
}

bool VulkanCalls::read(std::vector<Copy>& copies) {
    VkDeviceSize bytes = 0;
    for (const Copy& copy : copies) bytes += VkDeviceSize(copy.rect.extent.width) * copy.rect.extent.height * bytesPerPixel(copy.format);
    if (!reserve(bytes) || !begin()) return false;
    const auto isFirst = [&](size_t i) {
        for (size_t j = 0; j < i; ++j)
            if (copies[j].image == copies[i].image) return false;
        return true;
    };
    for (size_t i = 0; i < copies.size(); ++i)
        if (isFirst(i)) barrier(copies[i].image, copies[i].format, VK_IMAGE_LAYOUT_MAX_ENUM, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    VkDeviceSize offset = 0;
    for (const Copy& copy : copies) {
        VkBufferImageCopy region{};
        region.bufferOffset = offset;
        region.imageSubresource = {VkImageAspectFlags(isDepth(copy.format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT), 0,
                                   copy.layer, 1};
        region.imageOffset = {copy.rect.offset.x, copy.rect.offset.y, 0};
        region.imageExtent = {copy.rect.extent.width, copy.rect.extent.height, 1};
        vkCmdCopyImageToBuffer(commands_, copy.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer_, 1, &region);
        offset += VkDeviceSize(copy.rect.extent.width) * copy.rect.extent.height * bytesPerPixel(copy.format);
    }
    const VkClearColorValue magenta{{1, 0, 1, 1}};
    const VkClearDepthStencilValue someDepth{0.7f, 0};
    for (size_t i = 0; i < copies.size(); ++i) {
        if (!isFirst(i)) continue;
        const bool depth = isDepth(copies[i].format);
        barrier(copies[i].image, copies[i].format, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        const VkImageSubresourceRange all{VkImageAspectFlags(depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT), 0,
                                          VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
        if (depth)
            vkCmdClearDepthStencilImage(commands_, copies[i].image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &someDepth, 1, &all);
        else
            vkCmdClearColorImage(commands_, copies[i].image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &magenta, 1, &all);
        barrier(copies[i].image, copies[i].format, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_MAX_ENUM);
    }
    if (!submit()) return false;
    const uint8_t* from = mapped_;
    for (Copy& copy : copies) {
        const size_t size = size_t(copy.rect.extent.width) * copy.rect.extent.height * bytesPerPixel(copy.format);
        copy.bytes.assign(from, from + size);
        from += size;
    }
    return true;
}

bool VulkanCalls::begin() {
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    return vkBeginCommandBuffer(commands_, &info) == VK_SUCCESS;
}

bool VulkanCalls::submit() {
    VkMemoryBarrier host{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    host.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    host.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &host, 0, nullptr, 0, nullptr);
    VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    info.commandBufferCount = 1;
    info.pCommandBuffers = &commands_;
    return vkEndCommandBuffer(commands_) == VK_SUCCESS && vkQueueSubmit(queue_, 1, &info, fence_) == VK_SUCCESS &&
           vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX) == VK_SUCCESS && vkResetFences(device_, 1, &fence_) == VK_SUCCESS;
}

/** VK_IMAGE_LAYOUT_MAX_ENUM: the attachment layout, in which the caller gets and returns images. */
void VulkanCalls::barrier(VkImage image, VkFormat format, VkImageLayout from, VkImageLayout to) {
    const VkImageLayout attachment =
        isDepth(format) ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    const bool stencil = format == VK_FORMAT_D24_UNORM_S8_UINT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
    VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.oldLayout = from == VK_IMAGE_LAYOUT_MAX_ENUM ? attachment : from;
    barrier.newLayout = to == VK_IMAGE_LAYOUT_MAX_ENUM ? attachment : to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {VkImageAspectFlags(isDepth(format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT), 0,
                                VK_REMAINING_MIP_LEVELS, 0, VK_REMAINING_ARRAY_LAYERS};
    if (stencil) barrier.subresourceRange.aspectMask |= VK_IMAGE_ASPECT_STENCIL_BIT;
    vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr, 1,
                         &barrier);
}

bool VulkanCalls::reserve(VkDeviceSize bytes) {
    if (bytes <= reserved_) return true;
    vkDestroyBuffer(device_, buffer_, nullptr);
    vkFreeMemory(device_, memory_, nullptr);
    buffer_ = VK_NULL_HANDLE, memory_ = VK_NULL_HANDLE, reserved_ = 0;
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (vkCreateBuffer(device_, &info, nullptr, &buffer_) != VK_SUCCESS) return false;
    VkMemoryRequirements needs{};
    vkGetBufferMemoryRequirements(device_, buffer_, &needs);
    VkMemoryAllocateInfo allocation{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocation.allocationSize = needs.size;
    const int type = memoryType(needs.memoryTypeBits, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    allocation.memoryTypeIndex = uint32_t(type);
    void* mapped = nullptr;
    if (type < 0 || vkAllocateMemory(device_, &allocation, nullptr, &memory_) != VK_SUCCESS ||
        vkBindBufferMemory(device_, buffer_, memory_, 0) != VK_SUCCESS ||
        vkMapMemory(device_, memory_, 0, VK_WHOLE_SIZE, 0, &mapped) != VK_SUCCESS)
        return false;
    mapped_ = static_cast<uint8_t*>(mapped);
    reserved_ = bytes;
    return true;
}

}  // namespace dpl::mockxr
