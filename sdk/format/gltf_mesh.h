// SPDX-License-Identifier: Apache-2.0
// Writes the skinned mesh of an avatar as a plain glTF binary: textured, for viewers, editors and engines that know no splats, or with its
// splats, for engines that pose splats themselves.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** The colour texture of a mesh, borrowed. */
struct MeshTexture {
    std::span<const Vec2f> uv;       // one per vertex, 0 to 1, v down
    std::span<const uint8_t> image;  // a PNG or JPEG file, sRGB
    bool jpeg = false;
};

/** Makes a VRM 1.0 of a mesh. */
struct VrmAbout {
    std::string author;
};

/** InvalidArgument: no joint is a bone that VRM demands; the text names it. */
Status checkVrmBones(std::span<const JointData> joints);

/** A mesh for each layer at rest, with normals and a texture, skinned to the joints; clips are animations. No splats, no pose correctives,
 *  no vertex colours. The material is unlit, because the colours contain the light of the scan: viewers show them as they were
 *  photographed. `normals`: one per vertex, unit length, of the mesh at rest. draco: with KHR_draco_mesh_compression, which a viewer must
 *  know. vrm: with VRMC_vrm 1.0, of an avatar that rests in a T-pose and whose joints tell their humanoid bones (vrm_write.h); null:
 * without. Deterministic. InvalidArgument: an avatar without a mesh, normals that are not of its vertices or not unit, texture coordinates
 *  that are not of its vertices or not from 0 to 1, or as checkAvatarWithoutSplats() and addVrm(). Any thread. */
Result<std::vector<uint8_t>> writeGltfMesh(const AvatarData& avatar, std::span<const Vec3f> normals, const MeshTexture& texture,
                                           bool draco = false, const VrmAbout* vrm = nullptr);

/** The same with vertex colours instead of a texture, without Draco, and with the splats of the layers as
 *  DPL_skinned_gaussian_splatting (docs/formats/skinned-splats.md). InvalidArgument: also an avatar without splats, or as checkAvatar(). */
Result<std::vector<uint8_t>> writeGltfSkinnedSplats(const AvatarData& avatar, std::span<const Vec3f> normals);

}  // namespace dpl
