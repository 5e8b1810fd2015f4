// SPDX-License-Identifier: Apache-2.0
// precisions.bin: how well registration knows the poses of a scan's frames. Written and read by the stage register.
//
//   "DPRC" | version u32 | for each frame: joints (array of u32), matrix (array of f64, row-major)
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "reconstruction/input/capture/pose_precision.h"
#include "sdk/core/result.h"

namespace dpl {

Status writePrecisions(const std::vector<PosePrecision>& precisions, const std::filesystem::path& path);

/** One a frame. Errors name the file: Io, Version, CorruptData for arrays that do not fit and for numbers that are not finite. */
Result<std::vector<std::shared_ptr<const PosePrecision>>> readPrecisions(const std::filesystem::path& path, size_t frameCount,
                                                                         size_t jointCount);

}  // namespace dpl
