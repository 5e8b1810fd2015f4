// SPDX-License-Identifier: Apache-2.0
// A pose that a clip or a tracker has set, changed by the program: turned by hand, or moved aside.
#pragma once

#include <doppel/doppel.hpp>

namespace dpl {

/** Replaces the avatar's current pose by a variant of it. What its clothes remember stays, which setPose() alone would forget. */
inline doppel::Status changePose(doppel::Avatar& avatar, std::span<const float> rotations, std::span<const float> rootTranslation) {
    const auto remembered = avatar.motionState();
    if (!remembered) return remembered.error();
    if (auto set = avatar.setPose(rotations, rootTranslation); !set) return set;
    return avatar.setMotionState(*remembered);
}

}  // namespace dpl
