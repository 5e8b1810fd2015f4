// SPDX-License-Identifier: Apache-2.0
#include "platform/common/swapchain.h"

#include <algorithm>

namespace dpl::platform {
namespace {

/** A format of display values without conversion: the picture is encoded already. */
Result<VkSurfaceFormatKHR> formatOf(const Device& device, VkSurfaceKHR surface) {
    uint32_t count = 0;
    DPL_VK(vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical(), surface, &count, nullptr));
    std::vector<VkSurfaceFormatKHR> formats(count);
    DPL_VK(vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical(), surface, &count, formats.data()));
    formats.resize(count);
    for (const VkSurfaceFormatKHR& format : formats)
        if (format.format == VK_FORMAT_B8G8R8A8_UNORM || format.format == VK_FORMAT_R8G8B8A8_UNORM) return format;
    return Error{DPL_ERROR_UNSUPPORTED, "the window takes neither BGRA8 nor RGBA8 pictures"};
}

VkImageMemoryBarrier barrierOf(VkImage image, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    barrier.oldLayout = from, barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    return barrier;
}

}  // namespace

Result<std::unique_ptr<Swapchain>> Swapchain::create(Device& device, VkSurfaceKHR surface, VkImageUsageFlags usage) {
    std::unique_ptr<Swapchain> made(new Swapchain(device, surface, usage));
    VkBool32 presents = VK_FALSE;
    DPL_VK(vkGetPhysicalDeviceSurfaceSupportKHR(device.physical(), device.family(), surface, &presents));
    if (!presents) return Error{DPL_ERROR_UNSUPPORTED, "the graphics device " + device.name() + " cannot show pictures in this window"};
    return made;
}

Result<bool> Swapchain::make(VkExtent2D windowPx) {
    DPL_SHELL_OK(device_.waitIdle());
    VkSurfaceCapabilitiesKHR can{};
    DPL_VK(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical(), surface_, &can));
    VkExtent2D size = can.currentExtent;
    if (size.width == UINT32_MAX)
        size = {std::clamp(windowPx.width, can.minImageExtent.width, can.maxImageExtent.width),
                std::clamp(windowPx.height, can.minImageExtent.height, can.maxImageExtent.height)};
    if (size.width == 0 || size.height == 0) return false;
    if ((can.supportedUsageFlags & usage_) != usage_) return Error{DPL_ERROR_UNSUPPORTED, "pictures cannot be put into the window"};
    DPL_SHELL_TRY(const VkSurfaceFormatKHR format, formatOf(device_, surface_));
    // Displays that turn the images by a quarter give the size of the window and take images of the size before the turn.
    constexpr VkSurfaceTransformFlagsKHR kQuarterTurns = VK_SURFACE_TRANSFORM_ROTATE_90_BIT_KHR | VK_SURFACE_TRANSFORM_ROTATE_270_BIT_KHR;
    if (can.currentTransform & kQuarterTurns) std::swap(size.width, size.height);
    const VkSwapchainKHR old = swapchain_;
    VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
    info.surface = surface_;
    info.minImageCount = std::max(can.minImageCount, can.maxImageCount == 0 ? 3u : std::min(3u, can.maxImageCount));
    info.imageFormat = format.format;
    info.imageColorSpace = format.colorSpace;
    info.imageExtent = size;
    info.imageArrayLayers = 1;
    info.imageUsage = usage_;
    info.preTransform = can.currentTransform;
    info.compositeAlpha = (can.supportedCompositeAlpha & VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR) ? VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR
                                                                                            : VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
    info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
    info.clipped = VK_TRUE;
    info.oldSwapchain = old;
    VkSwapchainKHR made = VK_NULL_HANDLE;
    DPL_VK(vkCreateSwapchainKHR(device_.device(), &info, nullptr, &made));
    vkDestroySwapchainKHR(device_.device(), old, nullptr);
    swapchain_ = made, size_ = size, madeFor_ = windowPx, stale_ = true;  // until all that belongs to it is made
    format_ = format.format, transform_ = can.currentTransform, ++generation_;
    uint32_t count = 0;
    DPL_VK(vkGetSwapchainImagesKHR(device_.device(), swapchain_, &count, nullptr));
    images_.resize(count);
    DPL_VK(vkGetSwapchainImagesKHR(device_.device(), swapchain_, &count, images_.data()));
    destroySemaphores();
    drawn_.resize(count);
    const VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    for (VkSemaphore& s : drawn_) DPL_VK_MAKE(s, vkCreateSemaphore, device_.device(), semaphore);
    stale_ = false;
    return true;
}

void Swapchain::destroySemaphores() {
    for (VkSemaphore s : drawn_) vkDestroySemaphore(device_.device(), s, nullptr);
    drawn_.clear();
}

Swapchain::~Swapchain() {
    destroySemaphores();
    vkDestroySwapchainKHR(device_.device(), swapchain_, nullptr);
    vkDestroySurfaceKHR(device_.instance(), surface_, nullptr);
}

Result<std::optional<uint32_t>> Swapchain::acquire(VkExtent2D windowPx, VkSemaphore ready, uint64_t timeoutNs) {
    std::optional<uint32_t> acquired;
    if (windowPx.width == 0 || windowPx.height == 0) return acquired;
    for (int attempt = 0; attempt < 3; ++attempt) {
        if (stale_ || madeFor_.width != windowPx.width || madeFor_.height != windowPx.height) {
            DPL_SHELL_TRY(const bool sized, make(windowPx));
            if (!sized) return acquired;
        }
        uint32_t index = 0;
        const VkResult result = vkAcquireNextImageKHR(device_.device(), swapchain_, timeoutNs, ready, VK_NULL_HANDLE, &index);
        if (result == VK_SUCCESS || result == VK_SUBOPTIMAL_KHR) acquired = index;
        if (acquired || result == VK_TIMEOUT || result == VK_NOT_READY) return acquired;
        if (result != VK_ERROR_OUT_OF_DATE_KHR) return vulkanError(result, "vkAcquireNextImageKHR");
        stale_ = true;
    }
    return acquired;  // the window changes faster than images are made; the next frame tries again
}

void Swapchain::recordCopy(VkCommandBuffer commands, uint32_t index, VkImage picture, VkExtent2D pictureSize) const {
    // The submission waits for the image at the transfer stage.
    VkImageMemoryBarrier before = barrierOf(images_[index], VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    before.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0, nullptr, 1, &before);
    VkImageBlit region{};
    region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.srcOffsets[1] = {int32_t(pictureSize.width), int32_t(pictureSize.height), 1};
    region.dstOffsets[1] = {int32_t(size_.width), int32_t(size_.height), 1};
    const bool same = pictureSize.width == size_.width && pictureSize.height == size_.height;
    vkCmdBlitImage(commands, picture, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, images_[index], VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                   &region, same ? VK_FILTER_NEAREST : VK_FILTER_LINEAR);
    VkImageMemoryBarrier after = barrierOf(images_[index], VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    after.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, 0, 0, nullptr, 0, nullptr, 1,
                         &after);
}

Status Swapchain::present(uint32_t index) {
    VkPresentInfoKHR info{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
    info.waitSemaphoreCount = 1;
    info.pWaitSemaphores = &drawn_[index];
    info.swapchainCount = 1;
    info.pSwapchains = &swapchain_;
    info.pImageIndices = &index;
    const VkResult result = device_.present(info);
    if (result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR)
        stale_ = true;
    else if (result != VK_SUCCESS)
        return vulkanError(result, "vkQueuePresentKHR");
    return {};
}

}  // namespace dpl::platform
