// SPDX-License-Identifier: Apache-2.0
// Measures how much of an avatar's clothes lies inside its body.
#pragma once

#include <span>

#include "sdk/avatar/rig.h"
#include "sdk/core/jobs.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Share of garment vertices that lie inside the body, mean over the poses. The body is the layer with the role "body", garments those
 *  with the role "garment". Points deeper than 10 cm do not count: at such a depth the nearest part of the body is another one. 0 when the
 *  avatar has no body layer or no garment, or without poses. The avatar and the poses must have passed the checks of their readers. */
double garmentPenetration(const AvatarData& avatar, std::span<const Pose> poses, Jobs& jobs);

}  // namespace dpl
