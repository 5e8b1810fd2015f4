// SPDX-License-Identifier: Apache-2.0
// The result of training as a binary file, without loss. Reading checks every size before it allocates.
#pragma once

#include <filesystem>

#include "reconstruction/training/trainer/co_optimise.h"
#include "sdk/core/result.h"

namespace dpl {

Status writeTrainedFile(const CoOptimiseResult& result, const std::filesystem::path& path);
/** triangleCount, vertexCount and jointCount are those of the mesh that was trained. */
Result<CoOptimiseResult> readTrainedFile(const std::filesystem::path& path, size_t triangleCount, size_t vertexCount, size_t jointCount);

}  // namespace dpl
