// SPDX-License-Identifier: Apache-2.0
#include "platform/android/native/surface_renderer.h"

#include "platform/android/native/screen.h"

namespace dpl::android {

doppel::Result<std::unique_ptr<platform::Device>> SurfaceRenderer::openDevice() const {
    platform::Presentation presentation;
    presentation.applicationName = "doppel";
    presentation.instanceExtensions = surfaceExtensions();
    presentation.validation = validation_;
    return platform::Device::create(presentation);  // on Android, every queue family can present
}

doppel::Result<std::shared_ptr<SurfaceRenderer>> SurfaceRenderer::create(const DplContextInfo* info, bool validation) {
    std::shared_ptr<SurfaceRenderer> made(new SurfaceRenderer);
    made->validation_ = validation;
    auto opened = made->openDevice();
    if (!opened) return doppel::Error{DPL_ERROR_UNSUPPORTED, opened.error().message};
    made->device_ = std::move(*opened);
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

doppel::Status SurfaceRenderer::rebuild() {
    DPL_SHELL_TRY(std::unique_ptr<platform::Device> fresh, openDevice());
    const DplVulkanDevice device = fresh->forDoppel();
    if (dplRebuildVulkan(context_, &device) != DPL_OK) return doppel::lastError(DPL_ERROR_UNSUPPORTED);
    for (std::string& complaint : device_->complaints()) earlierComplaints_.push_back(std::move(complaint));
    device_ = std::move(fresh);
    deviceLost_ = false;
    return {};
}

doppel::Status SurfaceRenderer::makeScreen() {
    DPL_SHELL_TRY(const VkSurfaceKHR surface, makeSurface(device_->instance(), window_.get()));
    DPL_SHELL_TRY(screen_, Screen::create(*device_, context_, surface));
    return {};
}

doppel::Result<Outcome> SurfaceRenderer::draw(const FrameRequest& request) {
    std::lock_guard lock(mutex_);
    if (deviceLost_)
        if (const doppel::Status rebuilt = rebuild(); !rebuilt) return broken(rebuilt.error());
    if (!window_ || windowPx_.width == 0 || windowPx_.height == 0) return Outcome::NoWindow;
    if (!screen_)
        if (const doppel::Status made = makeScreen(); !made) return broken(made.error());
    const auto drawn = screen_->draw(windowPx_, request);
    if (!drawn) return broken(drawn.error());
    if (!drawn->shown) return Outcome::Skipped;
    if (drawn->avatars) return Outcome::Shown;
    if (drawn->avatars.error().code == DPL_ERROR_DEVICE) return broken(drawn->avatars.error());
    return drawn->avatars.error();
}

doppel::Result<Outcome> SurfaceRenderer::broken(const doppel::Error& error) {
    screen_.reset();
    switch (error.code) {
        case DPL_ERROR_NOT_FOUND:
            return Outcome::SurfaceLost;
        case DPL_ERROR_DEVICE:
            deviceLost_ = true;
            return Outcome::DeviceLost;
        case DPL_ERROR_OUT_OF_MEMORY:
            return error;
        case DPL_ERROR_UNSUPPORTED:  // while the device is lost: there is no other one
            return doppel::Error{deviceLost_ ? DPL_ERROR_DEVICE : DPL_ERROR_UNSUPPORTED, error.message};
        default:
            return doppel::Error{DPL_ERROR_DEVICE, error.message};
    }
}

std::vector<std::string> SurfaceRenderer::complaints() const {
    std::lock_guard lock(mutex_);
    std::vector<std::string> all = earlierComplaints_;
    for (std::string& complaint : device_->complaints()) all.push_back(std::move(complaint));
    return all;
}

}  // namespace dpl::android
