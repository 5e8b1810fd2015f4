// SPDX-License-Identifier: Apache-2.0
// Writes the skinned mesh of an avatar for stock viewers, editors and engines, alone or with its splats bound to it.
#pragma once

#include <filesystem>
#include <string>

#include "sdk/core/result.h"
#include "sdk/format/gltf_mesh.h"

namespace dpl {

/** Reads an avatar and writes its mesh at rest with area-weighted normals, vertex colours, skeleton and clips as a plain .glb
 * (writeGltfMesh). Returns lines of counts and sizes to show the user, and of what the file
 * cannot hold. InvalidArgument: `out` is no .glb, or the input is general splats. */
Result<std::string> exportMesh(const std::filesystem::path& avatar, const std::filesystem::path& out, const GltfMeshOptions& options = {});

}  // namespace dpl
