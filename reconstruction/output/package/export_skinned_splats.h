// SPDX-License-Identifier: Apache-2.0
// Writes the splats of an avatar on its skinned mesh, for engines that pose splats themselves.
#pragma once

#include <filesystem>
#include <string>

#include "sdk/core/result.h"

namespace dpl {

/** Reads an avatar and writes its mesh, with the weights that renderers use, vertex colours, its splats, skeleton and clips as a plain .glb
 *  (writeGltfSkinnedSplats). Returns lines to show the user: what the file cannot hold, counts and sizes. InvalidArgument: `out` is no
 *  .glb, the input is general splats, or the avatar has no splats. */
Result<std::string> exportSkinnedSplats(const std::filesystem::path& avatar, const std::filesystem::path& out);

}  // namespace dpl
