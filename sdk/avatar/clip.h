// SPDX-License-Identifier: Apache-2.0
// Clips on an avatar's own rig: checking and sampling.
#pragma once

#include <span>

#include "sdk/avatar/rig.h"
#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Refuses clips that do not fit the rig: sizes, joints out of range or named twice, times that do not rise, numbers that are not finite.
 */
Status checkClip(const ClipData& clip, std::span<const JointData> joints);

/** Last time minus first, seconds. */
double clipDurationS(const ClipData& clip);

/** The pose `timeS` after the clip's first key: slerp between keys along the shorter arc, held beyond the ends. Joints without a channel
 *  rest. The clip must have passed checkClip. */
Pose samplePose(const ClipData& clip, std::span<const JointData> joints, double timeS);
/** The same without an allocation once `pose` has the rig's size. */
void samplePose(const ClipData& clip, std::span<const JointData> joints, double timeS, Pose& pose);

}  // namespace dpl
