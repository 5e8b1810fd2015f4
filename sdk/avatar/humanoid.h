// SPDX-License-Identifier: Apache-2.0
// Recognises human bones by the names of joints and their place in the tree. Bone names are those of the VRM 1.0 humanoid ("hips",
// "leftUpperArm", "rightIndexProximal" ...), which glTF tools know.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sdk/format/avatar_data.h"

namespace dpl {

/** The VRM humanoid bone that a joint of this name usually is, or an empty string. Knows the names of SMPL-X, MakeHuman (default and
 *  game-engine rig, BVH files), Mixamo, Unreal, CMU/Daz BVH, Blender/Rigify, Biped and VRM, in any case and with any separator.
 *  A single name can be ambiguous ("LeftShoulder" is the clavicle in Mixamo and the upper arm elsewhere), so prefer humanoidBones(). */
std::string humanoidBoneFor(std::string_view jointName);

/** The humanoid bone of every joint of a skeleton (empty: none); each bone occurs at most once.
 *  If any joint already has a humanoidBone, all labels are returned unchanged. Otherwise the names decide, and the tree settles what they
 *  leave ambiguous: legs and spine meet at the hips; spine, chest and upperChest are the chain from the hips to the arms; a shoulder
 *  without an upper arm is the upper arm; a second foot along a leg is the toes. Where names do not tell hips, head and four limbs, the
 *  shape of the tree does (limbs_by_shape.h). standing: positions of the joints in a pose in which the person stands; empty: at rest. */
std::vector<std::string> humanoidBones(std::span<const JointData> joints, std::span<const Vec3f> standing = {});

/** Writes humanoidBones() into the joints. */
void assignHumanoidBones(std::vector<JointData>& joints);

/** All bone names that the functions above return, parents first. */
std::span<const std::string_view> humanoidBoneNames();

using BoneMap = std::map<std::string, size_t, std::less<>>;  // humanoid bone -> joint

BoneMap bonesOf(std::span<const JointData> joints, std::span<const Vec3f> standing = {});
std::optional<size_t> findBone(const BoneMap& bones, std::string_view bone);
/** upperChest, chest or spine: the joint that carries the arms. */
std::optional<size_t> topOfSpine(const BoneMap& bones);

}  // namespace dpl
