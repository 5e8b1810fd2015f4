// SPDX-License-Identifier: Apache-2.0
#include "platform/android/native/surface_renderer.h"

#include "platform/android/native/screen.h"

namespace dpl::android {

using platform::VulkanError;

std::unique_ptr<platform::Device> SurfaceRenderer::openDevice() const {
    platform::Presentation presentation;
    presentation.applicationName = "doppel";
    presentation.instanceExtensions = surfaceExtensions();
    presentation.validation = validation_;
    return std::make_unique<platform::Device>(presentation);  // on Android, every queue family can present
}

doppel::Result<std::shared_ptr<SurfaceRenderer>> SurfaceRenderer::create(const DplContextInfo* info, bool validation) {
    std::shared_ptr<SurfaceRenderer> made(new SurfaceRenderer);
    made->validation_ = validation;
    try {
        made->device_ = made->openDevice();
    } catch (const std::exception& error) {
        return doppel::Error{DPL_ERROR_UNSUPPORTED, error.what()};
    }
    const DplVulkanDevice device = made->device_->forDoppel();
    if (dplCreateVulkanContext(&device, info, &made->context_) != DPL_OK) return doppel::lastError(DPL_ERROR_UNSUPPORTED);
    return made;
}

SurfaceRenderer::~SurfaceRenderer() {
    screen_.reset();
    dplDestroyContext(context_);
}

std::string SurfaceRenderer::deviceName() const {
    std::lock_guard lock(mutex_);
    return device_->name();
}

void SurfaceRenderer::setWindow(Window window, VkExtent2D size) {
    std::lock_guard lock(mutex_);
    windowPx_ = size;
    if (window == window_) return;
    screen_.reset();  // before the window goes: a window has one swapchain at a time
    window_ = std::move(window);
}

void SurfaceRenderer::rebuild() {
    std::unique_ptr<platform::Device> fresh = openDevice();
    const DplVulkanDevice device = fresh->forDoppel();
    if (dplRebuildVulkan(context_, &device) != DPL_OK) throw std::runtime_error(dplGetLastError());
    for (std::string& complaint : device_->complaints()) earlierComplaints_.push_back(std::move(complaint));
    device_ = std::move(fresh);
    deviceLost_ = false;
}

doppel::Result<Outcome> SurfaceRenderer::draw(const FrameRequest& request) {
    std::lock_guard lock(mutex_);
    try {
        if (deviceLost_) rebuild();
        if (!window_ || windowPx_.width == 0 || windowPx_.height == 0) return Outcome::NoWindow;
        if (!screen_) screen_ = std::make_unique<Screen>(*device_, context_, makeSurface(device_->instance(), window_.get()));
        auto drawn = drawOnScreen(request);
        if (!drawn && drawn.error().code == DPL_ERROR_DEVICE) {
            screen_.reset();
            deviceLost_ = true;
            return Outcome::DeviceLost;
        }
        return drawn;
    } catch (const VulkanError& error) {
        screen_.reset();  // with it goes what the broken frame has acquired
        switch (error.code) {
            case VK_ERROR_SURFACE_LOST_KHR:
            case VK_ERROR_NATIVE_WINDOW_IN_USE_KHR:
                return Outcome::SurfaceLost;
            case VK_ERROR_DEVICE_LOST:
                deviceLost_ = true;
                return Outcome::DeviceLost;
            case VK_ERROR_OUT_OF_HOST_MEMORY:
            case VK_ERROR_OUT_OF_DEVICE_MEMORY:
                return doppel::Error{DPL_ERROR_OUT_OF_MEMORY, error.what()};
            default:
                return doppel::Error{DPL_ERROR_DEVICE, error.what()};
        }
    } catch (const std::exception& error) {
        screen_.reset();
        return doppel::Error{deviceLost_ ? DPL_ERROR_DEVICE : DPL_ERROR_UNSUPPORTED, error.what()};
    }
}

doppel::Result<Outcome> SurfaceRenderer::drawOnScreen(const FrameRequest& request) {
    const std::optional<doppel::Status> drawn = screen_->draw(windowPx_, request);
    if (!drawn) return Outcome::Skipped;
    if (!*drawn) return drawn->error();
    return Outcome::Shown;
}

std::vector<std::string> SurfaceRenderer::complaints() const {
    std::lock_guard lock(mutex_);
    std::vector<std::string> all = earlierComplaints_;
    for (std::string& complaint : device_->complaints()) all.push_back(std::move(complaint));
    return all;
}

}  // namespace dpl::android
