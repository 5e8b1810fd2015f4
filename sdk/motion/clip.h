// SPDX-License-Identifier: Apache-2.0
// Clips on an avatar's own rig: checking and sampling.
#pragma once

#include <span>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Refuses a clip that does not fit the rig: wrong array lengths, joints out of range or named twice, times that do not rise, numbers that
 *  are not finite (CorruptData). */
Status checkClip(const ClipData& clip, std::span<const JointData> joints);

/** Last time minus first, seconds. */
double clipDurationS(const ClipData& clip);

/** `timeS` wrapped around into the clip; 0 if the clip lasts no time. */
double loopedTimeS(const ClipData& clip, double timeS);

/** The pose `timeS` seconds after the first key. Rotations are interpolated by slerp along the shorter arc. Before the first and after the
 *  last key the pose is held. Joints without a channel stay at rest. The clip must have passed checkClip. */
Pose samplePose(const ClipData& clip, std::span<const JointData> joints, double timeS);
/** The same into `pose`; allocates nothing once it has the rig's size. */
void samplePose(const ClipData& clip, std::span<const JointData> joints, double timeS, Pose& pose);

}  // namespace dpl
