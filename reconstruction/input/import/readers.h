// SPDX-License-Identifier: Apache-2.0
// The readers of captures, one for each layout. docs/formats/captures.md says what each takes and which description it follows. Private to
// reconstruction/input/import. Errors name the file and the remedy.
#pragma once

#include <nlohmann/json.hpp>

#include "reconstruction/base/image_file.h"
#include "reconstruction/input/import/capture.h"

namespace dpl {

/** nerfstudio, NeRFCapture and COLMAP folders (or one model of COLMAP's), by the readers of reconstruction/input/capture. */
Result<Capture> readKnownScan(const std::filesystem::path& root);

/** transforms_train.json and, where they exist, transforms_val.json and transforms_test.json. */
Result<Capture> readNerfSynthetic(const std::filesystem::path& root);

/** A subject of the NeuMan data set. */
Result<Capture> readNeuman(const std::filesystem::path& root);

/** `root` holds keyframes/. `part`: "corrected_cameras" or "corrected_images" takes keyframes that Polycam corrected, "cameras" or "images"
 *  takes all uncorrected; otherwise all keyframes, corrected where they are. */
Result<Capture> readPolycam(const std::filesystem::path& root, const std::string& part = "");
/** Camera of one keyframe, of the size that the file states, else of its picture's. */
Result<Camerad> parsePolycamCamera(const nlohmann::json& object, const ImageHeader& picture, const std::string& where);

/** `root` holds metadata.json (or metadata) and rgb/ (or rgbd/). */
Result<Capture> readRecord3d(const std::filesystem::path& root);
/** An .r3d file, which is a zip. Its metadata and pictures are unpacked into `unpacked`, a folder that is made. */
Result<Capture> readRecord3dFile(const std::filesystem::path& file, const std::filesystem::path& unpacked);
/** Cameras of all frames of a recording, of the size that the metadata states, else of the first picture's. */
struct Record3dFrames {
    std::vector<Camerad> cameras;
    double framesPerSecond = 0;  // 0: not stated
};
Result<Record3dFrames> parseRecord3d(const nlohmann::json& metadata, const ImageHeader& firstPicture, const std::string& where);

/** Photos without cameras. */
Result<Capture> readPhotos(const std::filesystem::path& folder, uint32_t longSidePx);

/** "full_0007". */
std::string frameName(FrameKind kind, size_t index);

}  // namespace dpl
