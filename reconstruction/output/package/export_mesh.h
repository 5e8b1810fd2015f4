// SPDX-License-Identifier: Apache-2.0
// Writes the skinned mesh of an avatar, without splats, for stock viewers, editors and engines.
#pragma once

#include <filesystem>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

/** Reads an avatar and writes its mesh at rest with area-weighted normals, vertex colours, skeleton and clips as a plain .glb
 * (writeGltfMesh). Returns a line of counts and sizes to show the user. InvalidArgument: `out` is no .glb, or the input is general splats.
 */
Result<std::string> exportMesh(const std::filesystem::path& avatar, const std::filesystem::path& out);

}  // namespace dpl
