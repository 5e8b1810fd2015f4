// SPDX-License-Identifier: Apache-2.0
// Poses in which clothes get into a body's way: strides, raised arms, bends.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Poses of a person who walks, spreads the legs, bends and raises the arms, made by turning humanoid bones from rest. Empty for a rig
 *  without hips and two upper legs. */
std::vector<Pose> stressPoses(std::span<const JointData> joints);

/** stressPoses(), and poses that dancers and fighters take: lunges, a deep squat, kicks sideways, arms overhead and across. Garments are
 *  made so that they hold together in these. */
std::vector<Pose> clothPoses(std::span<const JointData> joints);

}  // namespace dpl
