// SPDX-License-Identifier: Apache-2.0
// The actions behind Controllers. Controllers are a comfort: what fails here is told, and drawing goes on. Internal to this room.
#pragma once

#include "platform/openxr/calls.h"
#include "platform/openxr/controllers.h"

namespace dpl::xr {

class Actions {
public:
    explicit Actions(const Runtime& runtime) : runtime_(runtime) {}
    ~Actions();
    Actions(const Actions&) = delete;
    Actions& operator=(const Actions&) = delete;

    /** Makes actions and suggests bindings, once a program. */
    Status create(Calls& calls);
    /** Once for each session, before its first frame. detach() before the session is destroyed. */
    Status attach(Calls& calls, XrSession session);
    void detach();
    Status sync(Calls& calls, XrSpace world, XrTime time, Controllers& controllers);

private:
    Status suggest(Calls& calls);

    const Runtime& runtime_;
    XrActionSet set_ = XR_NULL_HANDLE;
    XrAction aim_ = XR_NULL_HANDLE, select_ = XR_NULL_HANDLE, turn_ = XR_NULL_HANDLE;
    XrPath hands_[2]{};
    XrSession session_ = XR_NULL_HANDLE;
    XrSpace aimSpaces_[2]{};
};

}  // namespace dpl::xr
