// SPDX-License-Identifier: Apache-2.0
// The images that the window shows. A frame copies its picture into one of them.
#pragma once

#include <optional>
#include <vector>

#include "platform/desktop/device.h"

namespace dpl::platform {

class Swapchain {
public:
    explicit Swapchain(Device& device) : device_(device) {}
    ~Swapchain() { destroy(); }
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    /** An image that may be written once `ready` is signalled. Makes the images anew if the window has changed. Nothing while the window is
     *  minimised; then `ready` stays unsignalled. */
    std::optional<uint32_t> acquire(VkExtent2D windowPx, VkSemaphore ready);
    /** Records a copy of `picture`, which is in TRANSFER_SRC_OPTIMAL, into the image. It is scaled if the sizes differ. */
    void recordCopy(VkCommandBuffer commands, uint32_t index, VkImage picture, VkExtent2D pictureSize) const;
    /** The semaphore that the submission of that copy signals. */
    VkSemaphore drawn(uint32_t index) const { return drawn_[index]; }
    void present(uint32_t index);

private:
    bool make(VkExtent2D windowPx);
    void destroy();
    void destroySemaphores();

    Device& device_;
    VkSwapchainKHR swapchain_ = VK_NULL_HANDLE;
    VkExtent2D size_{}, madeFor_{};  // of its images; of the window when they were made
    bool stale_ = true;
    std::vector<VkImage> images_;
    std::vector<VkSemaphore> drawn_;
};

}  // namespace dpl::platform
