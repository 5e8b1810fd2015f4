// SPDX-License-Identifier: Apache-2.0
// What draws into one window: swapchain, render pass, composer, and what the frames in flight use. One thread at a time. Errors that end
// the screen are exceptions: platform::VulkanError, or std::runtime_error with a sentence. Its owner drops it then and makes another.
#pragma once

#include "platform/android/native/surface_renderer.h"
#include "platform/common/frame_slots.h"
#include "platform/common/swapchain.h"

namespace dpl::android {

class Screen {
public:
    /** Takes ownership of the surface, also if it throws. Device and context must live longer. */
    Screen(platform::Device& device, DplContext context, VkSurfaceKHR surface);
    /** Waits for its frames, unless the device is lost. */
    ~Screen();
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    /** Draws and shows a frame. Nothing: there was no image or no free slot within kMostWaitNs. An error: the background was shown without
     *  the avatars, and why. */
    std::optional<doppel::Status> draw(VkExtent2D windowPx, const FrameRequest& request);

private:
    void makeImages();
    void makePass(VkFormat format);
    void destroyPass();
    void destroyImages();
    doppel::Status record(uint32_t slotIndex, uint32_t image, const FrameRequest& request);

    platform::Device& device_;
    DplContext context_;
    platform::Swapchain swapchain_;
    platform::FrameSlots slots_;
    uint64_t frame_ = 0, madeFor_ = 0;  // generation of the swapchain that images_ belong to
    VkFormat passFormat_ = VK_FORMAT_UNDEFINED;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    uint32_t composer_ = 0;
    std::vector<VkImageView> views_;
    std::vector<float> sceneDepth_;  // of the app's scene, turned as the images are
    std::vector<VkFramebuffer> framebuffers_;
};

}  // namespace dpl::android
