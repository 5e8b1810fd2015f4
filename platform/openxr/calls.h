// SPDX-License-Identifier: Apache-2.0
// Results of OpenXR calls as errors. Internal to this room.
#pragma once

#include "platform/openxr/runtime.h"

namespace dpl::xr {

/** Checks the results of calls and remembers that the session was lost, so that the one who sees the error can make a new session. */
class Calls {
public:
    explicit Calls(const Runtime& runtime) : runtime_(runtime) {}

    /** call: its name, for the text. */
    Status check(XrResult result, const char* call) {
        if (result == XR_ERROR_SESSION_LOST || result == XR_SESSION_LOSS_PENDING) sessionLost = true;
        if (XR_SUCCEEDED(result)) return {};
        if (result == XR_ERROR_INSTANCE_LOST)
            return Error{DPL_ERROR_DEVICE, "the OpenXR runtime went away; start it and this program again"};
        return runtime_.failed(result, call);
    }
    static Status check(VkResult result, const char* call) {
        if (result == VK_SUCCESS) return {};
        if (result == VK_ERROR_DEVICE_LOST) return Error{DPL_ERROR_DEVICE, "the GPU was lost; start the program again"};
        return Error{
            result == VK_ERROR_OUT_OF_DEVICE_MEMORY || result == VK_ERROR_OUT_OF_HOST_MEMORY ? DPL_ERROR_OUT_OF_MEMORY : DPL_ERROR_DEVICE,
            std::string(call) + " failed with VkResult " + std::to_string(int(result))};
    }

    bool sessionLost = false;

private:
    const Runtime& runtime_;
};

}  // namespace dpl::xr

/** Returns the error of a call, if it has one, from the calling function, which has a Calls `calls_`. */
#define DPL_XR(call, ...) \
    if (doppel::Status done = calls_.check(call(__VA_ARGS__), #call); !done) return done.error()
#define DPL_XR_OK(...) \
    if (doppel::Status done = (__VA_ARGS__); !done) return done.error()
