// SPDX-License-Identifier: Apache-2.0
// The images that a window shows, and the surface that they belong to. A frame copies its picture into one of them, or draws into it.
#pragma once

#include <optional>
#include <vector>

#include "platform/common/device.h"

namespace dpl::platform {

class Swapchain {
public:
    /** Takes ownership of the surface, also if it fails. usage: of the images, TRANSFER_DST or COLOR_ATTACHMENT. DPL_ERROR_UNSUPPORTED:
     *  the device cannot show pictures there. The images are made by the first acquire. */
    static Result<std::unique_ptr<Swapchain>> create(Device& device, VkSurfaceKHR surface, VkImageUsageFlags usage);
    /** Submitted commands that use its images must have ended. */
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    /** An image that may be written once `ready` is signalled. Makes the images anew if the window has changed. Nothing while the window is
     *  minimised, or if there is no image within the time; then `ready` stays unsignalled. DPL_ERROR_UNSUPPORTED: the window takes no
     *  pictures of ours. */
    Result<std::optional<uint32_t>> acquire(VkExtent2D windowPx, VkSemaphore ready, uint64_t timeoutNs = UINT64_MAX);
    /** Grows whenever acquire has made the images anew; 0 before. What was made for them is of no use then. */
    uint64_t generation() const { return generation_; }
    VkExtent2D size() const { return size_; }
    VkFormat format() const { return format_; }
    /** How the display turns the images. They hold the picture turned by it already; see platform/android/native/rotated_view.h. */
    VkSurfaceTransformFlagBitsKHR transform() const { return transform_; }
    const std::vector<VkImage>& images() const { return images_; }
    /** Records a copy of `picture`, which is in TRANSFER_SRC_OPTIMAL, into the image. It is scaled if the sizes differ. */
    void recordCopy(VkCommandBuffer commands, uint32_t index, VkImage picture, VkExtent2D pictureSize) const;
    /** The semaphore that the submission which writes the image signals. */
    VkSemaphore drawn(uint32_t index) const { return drawn_[index]; }
    Status present(uint32_t index);

private:
    Swapchain(Device& device, VkSurfaceKHR surface, VkImageUsageFlags usage) : device_(device), surface_(surface), usage_(usage) {}
    /** False: the window has no size. */
    Result<bool> make(VkExtent2D windowPx);
    void destroySemaphores();

    Device& device_;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    VkImageUsageFlags usage_ = 0;
    VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
    VkFormat format_ = VK_FORMAT_UNDEFINED;
    VkSurfaceTransformFlagBitsKHR transform_ = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR;
    uint64_t generation_ = 0;
    VkExtent2D size_{}, madeFor_{};  // of its images; of the window when they were made
    bool stale_ = true;
    std::vector<VkImage> images_;
    std::vector<VkSemaphore> drawn_;
};

}  // namespace dpl::platform
