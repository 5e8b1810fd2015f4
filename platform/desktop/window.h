// SPDX-License-Identifier: Apache-2.0
// A GLFW window and its events. Use it from the main thread only.
#pragma once

#include <vulkan/vulkan.h>

#include <string>
#include <vector>

#include "platform/common/device.h"

struct GLFWwindow;

namespace dpl::platform {

class Window {
public:
    /** Opens a window. Throws std::runtime_error with GLFW's reason if there is no display. At most one window at a time. */
    Window(const std::string& title, uint32_t widthPx, uint32_t heightPx);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    /** For the device that shows pictures in this window; throws if the display cannot show Vulkan. */
    Presentation presentation(bool validation) const;
    VkSurfaceKHR makeSurface(VkInstance instance) const;

    /** Handles events. While the window is minimised, waits for the next one, at most 0.1 s. */
    void poll();
    bool wantsClose() const;
    void hide();
    /** Size of its pixels; 0 × 0 while it is minimised. */
    VkExtent2D sizePx() const;

    /** Files that were dropped on the window since the last call. */
    std::vector<std::string> takeDropped();
    /** Keys that were pressed since the last call, as GLFW_KEY_*. */
    std::vector<int> takeKeys();

    GLFWwindow* handle() const { return window_; }

private:
    GLFWwindow* window_ = nullptr;
    std::vector<std::string> dropped_;
    std::vector<int> keys_;
};

}  // namespace dpl::platform
