// SPDX-License-Identifier: Apache-2.0
// A window as tests see it. The layer in window_layer.cpp makes Vulkan surfaces of it, which behave as those of Android do.
#pragma once

#include <vulkan/vulkan_core.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

struct ANativeWindow {
    std::atomic<int> users{0};           // that keep the window alive
    std::atomic<int> surfaces{0};        // Vulkan surfaces of it
    std::atomic<int> swapchains{0};      // that were not destroyed
    std::atomic<bool> hasImages{false};  // a swapchain owns it; retired ones do not

    std::mutex mutex;  // guards what follows
    uint32_t width = 0, height = 0;
    VkSurfaceTransformFlagBitsKHR transform = VK_SURFACE_TRANSFORM_IDENTITY_BIT_KHR;
    VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
    // What the next call answers; VK_SUCCESS: what it would anyway.
    VkResult nextAcquire = VK_SUCCESS, nextPresent = VK_SUCCESS, nextSwapchain = VK_SUCCESS;
    std::vector<uint8_t> shown;  // the last picture, RGBA8 or BGRA8
    uint32_t shownWidth = 0, shownHeight = 0;
    uint64_t shownCount = 0;
    uint64_t wrong = 0;  // calls that Vulkan forbids and that the validation layer cannot know of
};

extern "C" {
/** The window of the next vkCreateHeadlessSurfaceEXT of this thread. */
__attribute__((visibility("default"))) void dplTestNextWindow(ANativeWindow* window);
/** What the next vkQueueSubmit of the program answers; VK_SUCCESS: what it would anyway. */
__attribute__((visibility("default"))) void dplTestNextSubmit(VkResult result);
}
