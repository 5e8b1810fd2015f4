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
    std::filesystem::path root = {};         // the folder of the capture, or the file
    std::filesystem::path calibration = {};  // CalibratedVideos
    std::vector<std::string> notes = {};     // sentences about what was chosen and what is left out
    std::filesystem::path foundIn = {};      // the folder of the given one in which the capture lies; empty: the given one is the capture
    std::filesystem::path part = {};         // Colmap, Polycam: the model or the keyframes that were given; empty: the reader chooses
};

/** Name of a layout for people. */
const char* captureName(CaptureKind kind);

/** Whether readScan() takes it as it is, so that nothing needs to be imported. */
bool isReadableScan(const CaptureLayout& layout);

/** The files that an import of the layout reads, in no order, at most 100,000. Where its files name others, all that lie below. */
std::vector<std::filesystem::path> filesOf(const CaptureLayout& layout);

/** Recognises the layout at `path`, or in the only folder of `path` that has one. For an unknown one the error says what lies there and
 * which command would help. */
Result<CaptureLayout> recogniseCapture(const std::filesystem::path& path);

}  // namespace dpl
