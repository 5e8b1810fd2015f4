// SPDX-License-Identifier: Apache-2.0
// An avatar that follows a tracked user. Where the headset tracks the body, the avatar takes its upper body and fingers over, by the rules
// of DPL_TRACK_FB_BODY. Elsewhere head and neck, arms, wrists and fingers follow by those of DPL_TRACK_OPENXR_HANDS (doppel.h,
// docs/reference/driving.md): arms reach for the wrists, fingers get the directions of the tracked ones. What is not located goes back to
// the pose beneath, without a jump.
#pragma once

#include <doppel/doppel.hpp>
#include <optional>
#include <vector>

#include "platform/openxr/user.h"

namespace dpl::xr {

class Puppet {
public:
    /** The puppet of an avatar, which must live longer. Nothing of general splats is driven, nor of avatars whose bones have no humanoid
     *  names. */
    static doppel::Result<Puppet> of(const doppel::Avatar& avatar);

    bool drives() const { return hands_.tracker.has_value(); }

    /** Turns the current pose of the avatar, such as a clip's set for this picture, into the user's. Of a puppet that drives nothing the
     *  pose stays. user: in avatar space, at the time of the picture. withHead: head and neck follow too. timeS: of the picture; it rises.
     */
    doppel::Status pose(const User& user, bool withHead, double timeS);

private:
    /** A tracker and its frame. */
    struct Follower {
        std::optional<doppel::Tracker> tracker;
        std::vector<float> rotations, positions, confidence;

        void resize(size_t joints);
        void put(size_t joint, const XrPosef& pose, bool located);
        doppel::Status pose(int64_t timeNs);
    };

    doppel::Status followSkeleton(const Body& body);

    DplAvatar avatar_ = nullptr;
    Follower hands_, body_;
    uint32_t skeleton_ = 0;  // that body_ was made for
};

}  // namespace dpl::xr
