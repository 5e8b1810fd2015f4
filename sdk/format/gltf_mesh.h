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

/** An expression of a mesh at weight 1. */
struct MeshMorph {
    uint8_t expression = 0;          // of kExpressionNames
    std::vector<uint32_t> vertices;  // that move or turn, rising
    std::vector<Vec3f> offsetsM;     // of each of them, from its place at rest
    std::vector<Vec3f> turns;        // of each of them: the change of its normal at rest
};

/** Makes a VRM 1.0 of a mesh. */
struct VrmAbout {
    std::string author;
};

struct GltfMeshOptions {
    bool draco = false;                 // with KHR_draco_mesh_compression, which a viewer must know
    const VrmAbout* vrm = nullptr;      // with VRMC_vrm 1.0 (vrm_write.h), of an avatar that rests in a T-pose; null: without
    std::span<const MeshMorph> morphs;  // expressions in rising order; empty: none
};

/** InvalidArgument: no joint is a bone that VRM demands; the text names it. */
Status checkVrmBones(std::span<const JointData> joints);

/** A mesh for each layer at rest, with normals and a texture, skinned to the joints; clips are animations, expressions morph targets by
 *  name. No splats, no pose correctives, no vertex colours. The material is unlit, because the colours contain the light of the scan:
 *  viewers show them as they were photographed. `normals`: one per vertex, unit length, of the mesh at rest. A mesh has the morph targets
 *  that move it; in a VRM they are its expressions too. Deterministic. InvalidArgument: an avatar without a mesh, normals that are not of
 *  its vertices or not unit, texture coordinates that are not of its vertices or not from 0 to 1, morphs that do not fit it, or as
 *  checkAvatarWithoutSplats() and addVrm(). Any thread. */
Result<std::vector<uint8_t>> writeGltfMesh(const AvatarData& avatar, std::span<const Vec3f> normals, const MeshTexture& texture,
                                           const GltfMeshOptions& options = {});

/** The same with vertex colours instead of a texture, without Draco, and with the splats of the layers as
 *  DPL_skinned_gaussian_splatting (docs/formats/skinned-splats.md). InvalidArgument: also an avatar without splats, or as checkAvatar(). */
Result<std::vector<uint8_t>> writeGltfSkinnedSplats(const AvatarData& avatar, std::span<const Vec3f> normals);

}  // namespace dpl
