// SPDX-License-Identifier: Apache-2.0
// Writes the skinned mesh of an avatar as a plain glTF binary: for viewers, editors and engines that know neither splats nor Draco.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct GltfMeshOptions {
    bool skinnedSplats = false;  // the avatar's splats too, as DPL_skinned_gaussian_splatting (docs/formats/skinned-splats.md)
};

/** A mesh for each layer at rest, with normals and vertex colours, skinned to the joints; clips are animations. No pose correctives and no
 *  light of the scene. The material is unlit, because the colours contain the light of the scan: viewers show them as they were
 * photographed. `normals`: one per vertex, unit length, of the mesh at rest. Deterministic. InvalidArgument: an avatar without a mesh,
 * normals that are not of its vertices or not unit, or as checkAvatarWithoutSplats() and with splats checkAvatar(). Any thread. */
Result<std::vector<uint8_t>> writeGltfMesh(const AvatarData& avatar, std::span<const Vec3f> normals, const GltfMeshOptions& options = {});

}  // namespace dpl
