// SPDX-License-Identifier: Apache-2.0
// Writes the skinned, textured mesh of an avatar, without splats, for stock viewers, editors and engines.
#pragma once

#include <filesystem>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

struct MeshExportOptions {
    std::filesystem::path avatar, out;
    std::string clip;           // name of a clip of the avatar, or path of a BVH or glTF file: the one animation; empty: the avatar's clips
    std::string animation;      // name or number of an animation in a glTF file; empty: the first
    uint32_t texturePx = 2048;  // side of the texture: a power of two, kLeastTexturePx to kMostTexturePx
    std::string textureFormat = "png";  // or "jpg"
    std::string compression = "none";   // or "draco"
    uint32_t threadCount = 0;           // 0: one thread a core; files do not depend on it
};

/** Reads an avatar and writes its mesh as it is drawn at rest, with area-weighted normals, a texture that is taken from its splats
 * (texture_bake.h), skeleton and clips, as a plain .glb (writeGltfMesh). Returns a line of counts and sizes to show the user. taskAt hears
 * what it does. InvalidArgument: `out` is no .glb, the input is general splats, the avatar has no mesh or no splats, another size of
 * texture.
 */
Result<std::string> exportMesh(const MeshExportOptions& options);

}  // namespace dpl
