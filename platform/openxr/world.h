// SPDX-License-Identifier: Apache-2.0
// The space in which a session places everything: its origin is on the floor. Internal to this room.
#pragma once

#include <optional>

#include "platform/openxr/calls.h"
#include "platform/openxr/poses.h"

namespace dpl::xr {

class World {
public:
    World() = default;
    ~World() {
        if (space_) xrDestroySpace(space_);
    }
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    /** A space at the floor below the user, or of the play area, or else 1.6 m below where the head was. */
    Status create(const Runtime& runtime, Calls& calls, XrSession session);
    XrSpace space() const { return space_; }

    void changePending(const XrEventDataReferenceSpaceChangePending& event);
    /** Pose of the new origin in the old one, once, from the first frame that is shown after the change. */
    std::optional<XrPosef> takeMove(XrTime displayTime);

private:
    XrSpace space_ = XR_NULL_HANDLE;
    XrReferenceSpaceType type_ = XR_REFERENCE_SPACE_TYPE_LOCAL;
    XrPosef inReferenceSpace_ = kIdentityPose;
    std::optional<XrPosef> move_;
    XrTime moveTime_ = 0;
};

}  // namespace dpl::xr
