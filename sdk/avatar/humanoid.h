// SPDX-License-Identifier: Apache-2.0
// Which human bone a joint is, by its name and its place in the tree. Names are those of the VRM 1.0 humanoid
// ("hips", "leftUpperArm", "rightIndexProximal" ...), the ones that glTF tools know.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** The VRM humanoid bone that a joint of this name usually is, or an empty string. Knows SMPL-X, MakeHuman (default and
 *  game-engine rig, and its BVH files), Mixamo, Unreal, CMU/Daz BVH, Blender/Rigify, Biped and VRM names, any case and separator.
 *  One name alone can be ambiguous ("LeftShoulder" is a clavicle to Mixamo, an upper arm to others): prefer humanoidBones(). */
std::string humanoidBoneFor(std::string_view jointName);

/** The humanoid bone of every joint of a skeleton (empty: none), each bone at most once. Starts from the names and settles what they
 *  leave open by the tree: hips are where legs and spine meet, spine/chest/upperChest are the chain up to the arms, a shoulder
 *  without an upper arm is one, a second foot down a leg is the toes. Labels already set in humanoidBone are kept as they are:
 *  if any joint has one, they are all returned unchanged. */
std::vector<std::string> humanoidBones(std::span<const JointData> joints);

/** Writes humanoidBones() into the joints. */
void assignHumanoidBones(std::vector<JointData>& joints);

/** Every bone name above, parents first. */
std::span<const std::string_view> humanoidBoneNames();

}  // namespace dpl
