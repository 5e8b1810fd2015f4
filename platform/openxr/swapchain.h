// SPDX-License-Identifier: Apache-2.0
// One swapchain of the runtime and where it stands in the cycle of acquire, wait and release. Internal to this room.
#pragma once

#include "platform/openxr/calls.h"

namespace dpl::xr {

class Swapchain {
public:
    Swapchain() = default;
    Swapchain(Swapchain&& other) noexcept { *this = std::move(other); }
    Swapchain& operator=(Swapchain&& other) noexcept;
    ~Swapchain();

    /** Error without a session lost: the runtime refuses this kind; another kind may do. */
    static Result<Swapchain> create(const Runtime& runtime, Calls& calls, XrSession session, const XrSwapchainCreateInfo& info);

    /** Acquires an image unless one is acquired, and waits until it may be drawn into. False: the wait timed out, try again with the next
     *  frame. */
    Result<bool> acquire(Calls& calls);
    /** Gives the image back if acquire() returned true since. */
    Status release(Calls& calls);

    XrSwapchain handle() const { return handle_; }
    const std::vector<VkImage>& images() const { return images_; }
    uint32_t current() const { return current_; }  // index of the acquired image

private:
    XrSwapchain handle_ = XR_NULL_HANDLE;
    std::vector<VkImage> images_;
    uint32_t current_ = 0;
    bool acquired_ = false, ready_ = false;
};

}  // namespace dpl::xr
