// SPDX-License-Identifier: Apache-2.0
// Poses as a clip of an avatar file.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** A clip that takes `poses` at `timesS`, seconds, strictly rising, one a pose; at least one. Joints that stay at rest have no channel. */
ClipData clipOfPoses(std::string name, std::vector<float> timesS, std::span<const Pose> poses);

}  // namespace dpl
