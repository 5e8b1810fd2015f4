// SPDX-License-Identifier: Apache-2.0
// Holds feet in place while they stand. A retargeted leg points where the recorded one does, but its thigh and shin have other lengths, so
// a foot that stood in the recording slides.
#pragma once

#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** What of a foot rests on the ground at one key. */
struct FootContact {
    bool ball = false, ankle = false;  // the joint "leftToes" or "rightToes"; the joint "leftFoot" or "rightFoot"
};

/** When a foot of the clip stands: its ball, or its ankle, is slower than 0.35 m/s and less than 8 cm above its rest height, for at
 *  least 0.08 s. One for each key; all false if the rig lacks the foot. side: "left" or "right". */
std::vector<FootContact> footContacts(std::span<const JointData> joints, const ClipData& clip, std::string_view side);

/** Turns each foot by a constant, so that its sole is flat while ball and ankle stand: recordings tell a foot's rotation up to a constant,
 *  too. Then moves each foot by an offset that holds the ball (or else the ankle) in one place as long as it stands, and on the floor if it
 * is within 6 cm of it. Between two stances the offset passes over smoothly. Hip and knee are solved for the moved ankle; that keeps the
 * rotation of the foot. The hips sink by up to 6 cm where a leg is too short. Legs without channels for upper leg, lower leg and foot stay.
 *  The clip must have passed checkClip on these joints; the result passes too. Deterministic. */
void plantFeet(std::span<const JointData> joints, ClipData& clip);

}  // namespace dpl
