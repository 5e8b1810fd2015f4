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

/** An image that is registered and cannot be used: its lens is not read, or its camera or its pose is none. */
struct UnreadColmapImage {
    std::string name;
    Error why;
};

struct ColmapModelFolder {
    std::filesystem::path folder;
    size_t images = 0;  // registered; 0 where it is the only model, which is not counted, or is damaged
};

/** The models of a project's folder, the one with the most images first: those in sparse and its folders; if there is none, those in
 *  colmap/sparse and its folders; else the folder itself. Where images are equal, sparse/0 comes before sparse/1 and before sparse. */
std::vector<ColmapModelFolder> findColmapModels(const std::filesystem::path& root);

/** The first of findColmapModels(); empty when there is none. */
std::filesystem::path findColmapModel(const std::filesystem::path& root);

/** Whether a folder holds the two files of a model, both binary or both text. */
bool isColmapModel(const std::filesystem::path& folder);

/** Reads images.bin and cameras.bin, or images.txt and cameras.txt if there is no images.bin. The lines of 2D points in images.txt may be
 *  missing. Images are sorted by name. Camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV are read; others are
 *  Unsupported where an image uses them. At most 1 GiB per file and 100,000 images. Errors name file, entry and remedy.
 *  unread: gets the images that cannot be used, unless no image can. Null: one of them is an error. */
Result<std::vector<ColmapImage>> readColmapModel(const std::filesystem::path& folder, std::vector<UnreadColmapImage>* unread = nullptr);

/** The bytes of a model's two files. */
struct ColmapBytes {
    bool binary = true;  // false: text
    std::string_view cameras, images;
};

/** readColmapModel() of files that are in memory. `folder` is only named in errors. Takes at most 64 bytes per byte of both files and
 *  1 MiB. */
Result<std::vector<ColmapImage>> decodeColmapModel(const ColmapBytes& bytes, const std::filesystem::path& folder,
                                                   std::vector<UnreadColmapImage>* unread = nullptr);

}  // namespace dpl
