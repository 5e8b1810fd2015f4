// SPDX-License-Identifier: Apache-2.0
// A GLFW window and its events. Use it from the main thread only.
#pragma once

#include <vulkan/vulkan.h>

#include <memory>
#include <string>
#include <vector>

#include "platform/common/device.h"

struct GLFWwindow;

namespace dpl::platform {

class Window {
public:
    /** Opens a window. growsWithScale: on a screen that is scaled, it is as much larger. DPL_ERROR_UNSUPPORTED, with GLFW's reason: there
     * is no display. At most one window at a time. */
    static Result<std::unique_ptr<Window>> create(const std::string& title, uint32_t widthPx, uint32_t heightPx, bool growsWithScale);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    /** For the device that shows pictures in this window. DPL_ERROR_UNSUPPORTED: the display cannot show Vulkan. */
    Result<Presentation> presentation(bool validation) const;
    Result<VkSurfaceKHR> makeSurface(VkInstance instance) const;

    /** Handles events. While the window is minimised, waits for the next one, at most 0.1 s. */
    void poll();
    bool wantsClose() const;
    void hide();
    /** Size of its pixels; 0 × 0 while it is minimised. */
    VkExtent2D sizePx() const;
    /** How many pixels its screen gives to one of a usual screen: 1 for 96 dots per inch, 2 for a screen that is scaled to 200 %. From 0.5
     * to 4. */
    float screenScale() const;

    /** Files that were dropped on the window since the last call. */
    std::vector<std::string> takeDropped();
    /** Keys that were pressed since the last call, as GLFW_KEY_*. */
    std::vector<int> takeKeys();

    GLFWwindow* handle() const { return window_; }

private:
    Window() = default;

    GLFWwindow* window_ = nullptr;
    std::vector<std::string> dropped_;
    std::vector<int> keys_;
};

}  // namespace dpl::platform
