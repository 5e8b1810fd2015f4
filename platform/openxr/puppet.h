// SPDX-License-Identifier: Apache-2.0
// An avatar that follows a tracked user: head and neck, arms, wrists and fingers. The rules are those of DPL_TRACK_OPENXR_HANDS
// (doppel.h, docs/reference/driving.md): arms reach for the wrists, fingers get the directions of the tracked ones, and what is not located
// goes back to the pose beneath, without a jump.
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

    bool drives() const { return tracker_.has_value(); }

    /** Turns the current pose of the avatar, such as a clip's set for this picture, into the user's. Of a puppet that drives nothing the
     *  pose stays. user: in avatar space, at the time of the picture. withHead: head and neck follow too. timeS: of the picture; it rises.
     */
    doppel::Status pose(const User& user, bool withHead, double timeS);

private:
    std::optional<doppel::Tracker> tracker_;
    std::vector<float> rotations_, positions_, confidence_;  // of a frame
};

}  // namespace dpl::xr
