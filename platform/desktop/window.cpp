// SPDX-License-Identifier: Apache-2.0
#include "platform/desktop/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <utility>

namespace dpl::platform {
namespace {

std::string lastGlfwError() {
    const char* text = nullptr;
    return glfwGetError(&text) == GLFW_NO_ERROR || !text ? "no reason was given" : text;
}

}  // namespace

Result<std::unique_ptr<Window>> Window::create(const std::string& title, uint32_t widthPx, uint32_t heightPx, bool growsWithScale) {
    std::unique_ptr<Window> made(new Window);
    const auto failed = [] { return Error{DPL_ERROR_UNSUPPORTED, "cannot open a window: " + lastGlfwError()}; };
    if (!glfwInit()) return failed();
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, growsWithScale ? GLFW_TRUE : GLFW_FALSE);
    made->window_ = glfwCreateWindow(int(widthPx), int(heightPx), title.c_str(), nullptr, nullptr);
    if (!made->window_) return failed();
    glfwSetWindowUserPointer(made->window_, made.get());
    glfwSetDropCallback(made->window_, [](GLFWwindow* window, int count, const char** paths) {
        auto& dropped = static_cast<Window*>(glfwGetWindowUserPointer(window))->dropped_;
        dropped.insert(dropped.end(), paths, paths + count);
    });
    // Dear ImGui installs its own callback later and passes keys on to this one.
    glfwSetKeyCallback(made->window_, [](GLFWwindow* window, int key, int, int action, int) {
        if (action == GLFW_PRESS) static_cast<Window*>(glfwGetWindowUserPointer(window))->keys_.push_back(key);
    });
    return made;
}

Window::~Window() {
    if (window_) glfwDestroyWindow(window_);
    glfwTerminate();
}

Result<Presentation> Window::presentation(bool validation) const {
    uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    if (!names)
        return Error{DPL_ERROR_UNSUPPORTED,
                     "no Vulkan driver can show pictures in a window here; install one (Debian: mesa-vulkan-drivers)"};
    Presentation made;
    made.applicationName = "doppel-viewer";
    made.instanceExtensions.assign(names, names + count);
    made.canPresent = [](VkInstance instance, VkPhysicalDevice physical, uint32_t family) {
        return glfwGetPhysicalDevicePresentationSupport(instance, physical, family) == GLFW_TRUE;
    };
    made.validation = validation;
    return made;
}

Result<VkSurfaceKHR> Window::makeSurface(VkInstance instance) const {
    VkSurfaceKHR surface = VK_NULL_HANDLE;
    DPL_VK(glfwCreateWindowSurface(instance, window_, nullptr, &surface));
    return surface;
}

void Window::poll() {
    const VkExtent2D size = sizePx();
    if (size.width == 0 || size.height == 0)
        glfwWaitEventsTimeout(0.1);
    else
        glfwPollEvents();
}

bool Window::wantsClose() const {
    return glfwWindowShouldClose(window_);
}

void Window::hide() {
    glfwHideWindow(window_);
    glfwPollEvents();
}

VkExtent2D Window::sizePx() const {
    if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED)) return {0, 0};
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    return {uint32_t(width), uint32_t(height)};
}

float Window::screenScale() const {
    float x = 1, y = 1;
    glfwGetWindowContentScale(window_, &x, &y);
    return x >= 0.5f && x <= 4 ? x : 1;
}

std::vector<std::string> Window::takeDropped() {
    return std::exchange(dropped_, {});
}

std::vector<int> Window::takeKeys() {
    return std::exchange(keys_, {});
}

}  // namespace dpl::platform
