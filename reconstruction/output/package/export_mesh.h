// SPDX-License-Identifier: Apache-2.0
// Writes the skinned, textured mesh of an avatar, without splats, for stock viewers, editors and engines.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "reconstruction/input/capture/train_frame.h"
#include "sdk/core/result.h"

namespace dpl {

struct MeshExportOptions {
    std::filesystem::path avatar, out;
    std::string clip;           // name of a clip of the avatar, or path of a BVH or glTF file: the one animation; empty: the avatar's clips
    std::string animation;      // name or number of an animation in a glTF file; empty: the first
    uint32_t texturePx = 2048;  // side of the texture: a power of two, kLeastTexturePx to kMostTexturePx
    std::string textureFormat = "png";     // or "jpg"
    std::string compression = "none";      // or "draco" or "meshopt"
    std::optional<std::string> vrmAuthor;  // a VRM 1.0 of this author, in a T-pose and without clips; `out` then ends in .vrm
    uint32_t threadCount = 0;              // 0: one thread a core; files do not depend on it
};

/** Why a mesh cannot be written by these options; empty if it can. */
std::string wrongMeshExport(const MeshExportOptions& options);

/** Reads an avatar and writes its mesh as it is drawn at rest, with area-weighted normals, a texture that is taken from its splats
 *  (texture_bake.h), skeleton, clips and expressions, by writeGltfMesh. Returns a line of counts and sizes to show the user. taskAt hears
 * what it does. InvalidArgument: wrongMeshExport(), the input is general splats, the avatar has no mesh or no splats, another size of
 * texture, or for a VRM a skeleton that lacks bones. photographs: of the same avatar, with the poses that it has in them; see
 * bakeTexture(). */
Result<std::string> exportMesh(const MeshExportOptions& options, std::span<const TrainFrame> photographs = {});

}  // namespace dpl
