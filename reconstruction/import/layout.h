// SPDX-License-Identifier: Apache-2.0
// Recognises what lies in a folder or file, by the names of its files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

enum class CaptureKind : uint8_t {
    ScanFolder,
    Nerfstudio,     // transforms.json; NeRFCapture writes the same
    NerfSynthetic,  // transforms_train.json
    Colmap,
    Neuman,  // a COLMAP model beside segmentations/
    Polycam,
    Record3dFolder,
    Record3dFile,
    CalibratedVideos,  // a Qualisys or Pose2Sim calibration beside videos
    Video,
    Photos,
};

struct CaptureLayout {
    CaptureKind kind = CaptureKind::Photos;
    std::filesystem::path root;         // the folder of the capture, or the file
    std::filesystem::path calibration;  // CalibratedVideos
};

/** Name of a layout for people. */
const char* captureName(CaptureKind kind);

/** Recognises the layout at `path`. For an unknown one the error says what lies there and which command would help. */
Result<CaptureLayout> recogniseCapture(const std::filesystem::path& path);

/** Regular files of a folder whose extension is one of `extensions` (lower case, with dots; compared without case), in natural order of
 *  their names: "2.jpg" before "10.jpg". Hidden files are left out. Stops at 100,000 files. */
std::vector<std::filesystem::path> filesWith(const std::filesystem::path& folder, std::initializer_list<const char*> extensions);

/** Whether `a` comes before `b` when runs of digits count as numbers. */
bool naturallyBefore(std::string_view a, std::string_view b);

std::vector<std::filesystem::path> picturesIn(const std::filesystem::path& folder);
std::vector<std::filesystem::path> videosIn(const std::filesystem::path& folder);

}  // namespace dpl
