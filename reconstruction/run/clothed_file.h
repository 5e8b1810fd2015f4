// SPDX-License-Identifier: Apache-2.0
// The layers of a clothed subject as a file of the garments stage.
#pragma once

#include <filesystem>

#include "reconstruction/subject/garments/clothed_mesh.h"

namespace dpl {

Status writeClothedFile(const ClothedMesh& clothed, const std::filesystem::path& path);
/** Refuses a damaged file and a mesh that does not fit a rig of `jointCount` joints; the error names the file and what to do. */
Result<ClothedMesh> readClothedFile(const std::filesystem::path& path, size_t jointCount);

}  // namespace dpl
