// SPDX-License-Identifier: Apache-2.0
// Brings a camera and its picture to one size. What can be derived from the picture is not demanded of the file.
#pragma once

#include "reconstruction/base/image_file.h"
#include "reconstruction/input/capture/scan_readers.h"

namespace dpl {

/** Sets the size of a camera whose intrinsics are set: the one that its file states under two keys, else that of its picture. If only one
 *  key is there, the other side follows from the picture's shape. CorruptData: a stated side is no size. CorruptData: no size is stated,
 *  and the principal point is so far from the picture's middle that the intrinsics belong to another size. */
Status takeSize(Camerad& camera, const JsonFields& fields, const char* widthKey, const char* heightKey, const ImageHeader& picture);

/** Gives a camera the size of its stored picture, and scales its intrinsics where that is another size of the same shape. Returns whether
 *  it was. CorruptData: another shape. */
Result<bool> fitToPicture(Camerad& camera, const ImageHeader& picture, const std::filesystem::path& image, const std::string& where);

/** fitToPicture() of a picture whose size is read. Errors also of the picture. */
Result<bool> fitToPictureFile(Camerad& camera, const std::filesystem::path& image, const std::string& where);

/** CorruptData: a mask has another size than its picture. */
Status checkMaskSize(const ImageHeader& mask, const ImageHeader& picture, const std::filesystem::path& file);

/** Adds a sentence to what the import and the reconstruction print of a scan. Empty: adds nothing. */
void addAssumption(Scan& scan, const std::string& sentence);

/** Adds to the scan's assumptions that `frames` cameras were scaled. */
void noteScaledCameras(Scan& scan, size_t frames);

}  // namespace dpl
