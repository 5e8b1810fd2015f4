// SPDX-License-Identifier: Apache-2.0
// The user's hands by XR_EXT_hand_tracking. Hands are a comfort: what fails here is told, and drawing goes on. Internal to this room.
#pragma once

#include "platform/openxr/calls.h"
#include "platform/openxr/user.h"

namespace dpl::xr {

class HandTracking {
public:
    explicit HandTracking(const Runtime& runtime) : runtime_(runtime) {}
    ~HandTracking() { stop(); }
    HandTracking(const HandTracking&) = delete;
    HandTracking& operator=(const HandTracking&) = delete;

    /** Makes a tracker for each hand. After an error there is none. */
    Status start(Calls& calls, XrSession session);
    /** Writes the joints that are located, in `world`. After an error, and without trackers, no joint is. */
    Status locate(Calls& calls, XrSpace world, XrTime time, Hand (&hands)[2]) const;

private:
    void stop();

    const Runtime& runtime_;
    XrHandTrackerEXT trackers_[2]{};
    PFN_xrLocateHandJointsEXT locate_ = nullptr;
};

}  // namespace dpl::xr
