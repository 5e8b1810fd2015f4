// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/swapchain.h"

#include <algorithm>

#include "platform/openxr/enumerate.h"

namespace dpl::xr {
namespace {

constexpr XrDuration kImageTimeoutNs = 1'000'000'000;
constexpr size_t kMaxImages = 16;

}  // namespace

Swapchain& Swapchain::operator=(Swapchain&& other) noexcept {
    std::swap(handle_, other.handle_);
    std::swap(images_, other.images_);
    std::swap(current_, other.current_);
    std::swap(acquired_, other.acquired_);
    std::swap(ready_, other.ready_);
    return *this;
}

Swapchain::~Swapchain() {
    if (handle_) xrDestroySwapchain(handle_);
}

Result<Swapchain> Swapchain::create(const Runtime& runtime, Calls& calls_, XrSession session, const XrSwapchainCreateInfo& info) {
    Swapchain made;
    DPL_XR(xrCreateSwapchain, session, &info, &made.handle_);
    std::vector<XrSwapchainImageVulkan2KHR> images;
    DPL_XR_OK(calls_.check(enumerate(images, XrSwapchainImageVulkan2KHR{XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR},
                                     [&](auto capacity, auto count, auto out) {
                                         return xrEnumerateSwapchainImages(made.handle_, capacity, count,
                                                                           reinterpret_cast<XrSwapchainImageBaseHeader*>(out));
                                     }),
                           "xrEnumerateSwapchainImages"));
    const bool whole = std::all_of(images.begin(), images.end(), [](const auto& image) { return image.image != VK_NULL_HANDLE; });
    if (images.empty() || images.size() > kMaxImages || !whole)
        return Error{DPL_ERROR_DEVICE,
                     "the runtime made a swapchain of " + std::to_string(images.size()) + " images or with images missing; update it"};
    for (const auto& image : images) made.images_.push_back(image.image);
    return made;
}

Result<bool> Swapchain::acquire(Calls& calls_) {
    if (!acquired_) {
        XrSwapchainImageAcquireInfo info{XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO};
        DPL_XR(xrAcquireSwapchainImage, handle_, &info, &current_);
        acquired_ = true;
        if (current_ >= images_.size()) return Error{DPL_ERROR_DEVICE, "the runtime handed out a swapchain image that it had not listed"};
    }
    if (ready_) return true;
    XrSwapchainImageWaitInfo info{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO};
    info.timeout = kImageTimeoutNs;
    const XrResult result = xrWaitSwapchainImage(handle_, &info);
    DPL_XR_OK(calls_.check(result, "xrWaitSwapchainImage"));
    ready_ = result != XR_TIMEOUT_EXPIRED;
    return ready_;
}

Status Swapchain::release(Calls& calls_) {
    if (!ready_) return {};
    acquired_ = ready_ = false;
    XrSwapchainImageReleaseInfo info{XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO};
    DPL_XR(xrReleaseSwapchainImage, handle_, &info);
    return {};
}

}  // namespace dpl::xr
