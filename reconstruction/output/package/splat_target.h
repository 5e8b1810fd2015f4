// SPDX-License-Identifier: Apache-2.0
// The formats that splats are exported to.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reconstruction/output/package/posed_splats.h"

namespace dpl {

enum class SplatTarget { None, Glb, Spz, Ply, CompressedPly };

/** By the end of the name. */
SplatTarget splatTargetOf(const std::filesystem::path& out);

/** The splats as a file of that format; what it cannot hold is added to `lost`. */
Result<std::vector<uint8_t>> splatFileOf(const StaticSplatData& splats, SplatTarget target, const ExportOptions& options,
                                         std::vector<std::string>& lost);

/** Which viewers show the file upright. */
std::string viewersFor(SplatTarget target, const ExportOptions& options);

}  // namespace dpl
