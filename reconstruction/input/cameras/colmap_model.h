// SPDX-License-Identifier: Apache-2.0
// Reads a COLMAP sparse model, text or binary: cameras and images, without 3D points.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "reconstruction/input/cameras/camera_check.h"

namespace dpl {

/** One registered image. `camera` has passed checkCamera. Its world is COLMAP's: scale, origin and up are arbitrary. */
struct ColmapImage {
    std::string name;  // path relative to the image folder, as COLMAP wrote it; unchecked
    Camerad camera;
    LensDistortion lens;
};

/** The folder of a model inside a scan folder: the first of sparse/0, sparse, colmap/sparse/0 and the root that has one; else empty. */
std::filesystem::path findColmapModel(const std::filesystem::path& root);

/** Reads images.bin and cameras.bin, or images.txt and cameras.txt if there is no images.bin. Images are sorted by name. Camera models
 *  SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV are read; others are Unsupported. At most 1 GiB per file and 100,000 images.
 *  Errors name file, entry and remedy. */
Result<std::vector<ColmapImage>> readColmapModel(const std::filesystem::path& folder);

/** The bytes of a model's two files. */
struct ColmapBytes {
    bool binary = true;  // false: text
    std::string_view cameras, images;
};

/** readColmapModel() of files that are in memory. `folder` is only named in errors. Takes at most 64 bytes per byte of both files and
 *  1 MiB. */
Result<std::vector<ColmapImage>> decodeColmapModel(const ColmapBytes& bytes, const std::filesystem::path& folder);

}  // namespace dpl
