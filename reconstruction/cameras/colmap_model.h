// SPDX-License-Identifier: Apache-2.0
// A COLMAP sparse model (cameras and images; 3D points are not read), text or binary.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reconstruction/cameras/camera_check.h"

namespace dpl {

/** One registered image. `camera` is checked; its world is COLMAP's own: scale, origin and up are arbitrary. */
struct ColmapImage {
    std::string name;  // relative to the image folder, as COLMAP wrote it; not yet checked as a path
    Camerad camera;
    LensDistortion lens;
};

/** The folder of a model inside a scan folder (root, sparse, sparse/0, colmap/sparse/0), or an empty path. */
std::filesystem::path findColmapModel(const std::filesystem::path& root);

/** Reads cameras.bin + images.bin, or cameras.txt + images.txt (binary wins when both are there), sorted by name. Camera models
 *  SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV; others are refused with the remedy. */
Result<std::vector<ColmapImage>> readColmapModel(const std::filesystem::path& folder);

}  // namespace dpl
