// SPDX-License-Identifier: Apache-2.0
// The user's body by XR_FB_body_tracking. It is a comfort, as hands are: what fails here is told, and drawing goes on. Internal to this
// room.
#pragma once

#include "platform/openxr/calls.h"
#include "platform/openxr/user.h"

namespace dpl::xr {

class BodyTracking {
public:
    explicit BodyTracking(const Runtime& runtime) : runtime_(runtime) {}
    ~BodyTracking() { stop(); }
    BodyTracking(const BodyTracking&) = delete;
    BodyTracking& operator=(const BodyTracking&) = delete;

    /** Makes the tracker. After an error there is none. */
    Status start(Calls& calls, XrSession session);
    /** Writes the joints that are located, in `world`, and a rest pose that is new. After an error, and without a tracker, no joint is. */
    Status locate(Calls& calls, XrSpace world, XrTime time, Body& body);

private:
    void stop();
    Status readSkeleton(Calls& calls, Body& body) const;

    const Runtime& runtime_;
    XrBodyTrackerFB tracker_ = XR_NULL_HANDLE;
    PFN_xrLocateBodyJointsFB locate_ = nullptr;
    PFN_xrGetBodySkeletonFB skeleton_ = nullptr;
    std::optional<uint32_t> known_;  // skeletonChangedCount of the rest pose that was read
};

}  // namespace dpl::xr
