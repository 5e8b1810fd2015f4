// SPDX-License-Identifier: Apache-2.0
// What draws into one window: swapchain, render pass, composer, and what the frames in flight use. One thread at a time. An error ends the
// screen: its owner drops it and makes another. Codes: platform/common/errors.h.
#pragma once

#include "platform/android/native/surface_renderer.h"
#include "platform/common/floor_shadow.h"
#include "platform/common/frame_slots.h"
#include "platform/common/swapchain.h"

namespace dpl::android {

/** A frame that did not end the screen. */
struct DrawnFrame {
    bool shown = false;      // false: there was no image or no free slot within kMostWaitNs
    doppel::Status avatars;  // an error: the background was shown without the avatars, and why
};

class Screen {
public:
    /** Takes ownership of the surface, also if it fails. Device and context must live longer. */
    static doppel::Result<std::unique_ptr<Screen>> create(platform::Device& device, DplContext context, VkSurfaceKHR surface);
    /** Waits for its frames, unless the device is lost. */
    ~Screen();
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    /** Draws and shows a frame. */
    doppel::Result<DrawnFrame> draw(VkExtent2D windowPx, const FrameRequest& request);

private:
    Screen(platform::Device& device, DplContext context) : device_(device), context_(context) {}
    doppel::Status makeImages();
    doppel::Status makePass(VkFormat format);
    void destroyPass();
    void destroyImages();
    doppel::Status setShadows(uint32_t slotIndex, const FrameRequest& request);
    /** An error ends the screen; one of `avatars` does not. */
    doppel::Status record(uint32_t slotIndex, uint32_t image, const FrameRequest& request, doppel::Status& avatars);

    platform::Device& device_;
    DplContext context_;
    std::unique_ptr<platform::Swapchain> swapchain_;
    std::unique_ptr<platform::FrameSlots> slots_;
    uint64_t frame_ = 0, madeFor_ = 0;  // generation of the swapchain that images_ belong to
    VkFormat passFormat_ = VK_FORMAT_UNDEFINED;
    VkRenderPass pass_ = VK_NULL_HANDLE;
    uint32_t composer_ = 0;
    std::unique_ptr<platform::FloorShadows> shadows_;  // of pass_
    std::vector<VkImageView> views_;
    std::vector<float> sceneDepth_;  // of the app's scene, turned as the images are
    std::vector<VkFramebuffer> framebuffers_;
};

}  // namespace dpl::android
