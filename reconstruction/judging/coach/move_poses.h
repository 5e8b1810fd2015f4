// SPDX-License-Identifier: Apache-2.0
// Poses that show a move, for pictures of advice and for clips of the avatar. They are made for the rig; nobody filmed them.
#pragma once

#include <string_view>
#include <vector>

#include "sdk/avatar/aimed_pose.h"

namespace dpl {

/** One round of a move, a pose a picture. It ends where it begins, so it can be shown in a loop. */
struct MoveClip {
    std::string_view name;  // "walking"
    double seconds = 0;     // of the round
    std::vector<Pose> poses;
};

/** Walking on the spot, a squat and a turn on the spot. The feet stand at the height at which they rest. Empty on a rig without hips and
 *  two upper legs. */
std::vector<MoveClip> moveClips(std::span<const JointData> joints);

/** Two walks on the spot as clips of the rig, which end where they begin: "walk", 1.2 s, and "stroll", 1.6 s, with shorter steps. Empty as
 *  moveClips(). */
std::vector<ClipData> walkClips(std::span<const JointData> joints);

/** A pose in the middle of the first move of the guide to filming that the sentence names (missingMoves() in moves.h); standing where it
 *  names none. */
Pose poseOfMove(std::span<const JointData> joints, std::string_view sentence);

}  // namespace dpl
