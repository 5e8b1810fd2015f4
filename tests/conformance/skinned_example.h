// SPDX-License-Identifier: Apache-2.0
// The example of the glTF extension DPL_skinned_gaussian_splatting: its file, pictures by the library, and the numbers behind them.
#pragma once

#include <filesystem>

#include "sdk/core/result.h"

namespace dpl {

/** Writes into the folder:
 *
 *    example.glb   a sleeve of two joints, open at both ends, with one clip
 *    views.json    for each picture its name, time in the clip and camera
 *    NAME.png      by dplRender on the CPU, over white, 8 bits
 *    NAME.f32      by dplWriteSplats for the eye of that camera, 13 floats a splat: position, covariance xx xy xz yy yz zz, opacity, colour
 *
 * The first three are in docs/formats/skinned-splats. Deterministic. Errors are those of files. */
Status writeSkinnedExample(const std::filesystem::path& folder);

/** Whether the pictures of both folders are the same within one level, for machines whose floats round differently. The error says where
 *  they differ. */
Status compareSkinnedPictures(const std::filesystem::path& made, const std::filesystem::path& kept);

}  // namespace dpl
