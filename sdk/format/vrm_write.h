// SPDX-License-Identifier: Apache-2.0
// Writes the root extension VRMC_vrm 1.0 (https://github.com/vrm-c/vrm-specification): which joint is which bone, and what others may do
// with the person. Internal. Only .cpp files include it, because the JSON header is slow to compile.
#pragma once

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/glb_builder.h"
#include "sdk/format/gltf_mesh.h"

namespace dpl {

/** Adds the extension, after addSkeletonAndClips(): its nodes are those. Bones are told by JointData::humanoidBone. Permissions are the
 *  strictest: the author alone uses it, nobody sells, changes or passes it on. Expressions: VRM's presets as mixtures of the morphs
 *  (vrm_expressions.h), and each morph by its own name. Where no bone moves the eyes and morphs do, gazes are expressions. The avatar has
 *  passed writeGltfMesh()'s checks, morphs too. InvalidArgument: no author, or the skeleton lacks a bone that VRM demands; the text names
 *  it. */
Status addVrm(GlbBuilder& glb, const AvatarData& avatar, const VrmAbout& about, std::span<const MeshMorph> morphs);

}  // namespace dpl
