// SPDX-License-Identifier: Apache-2.0
// The frames of the scan that a run was made of, with their cameras and the poses that the run found (docs/formats/poses.md).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/math/camera.h"

namespace dpl {

struct ComparedFrame {
    std::string name, split;                // train, validation or test
    std::string image, mask;                // paths from the scan's folder, or absolute; mask: empty if there is none
    Camerad camera;                         // metres
    double k1 = 0, k2 = 0, p1 = 0, p2 = 0;  // distortion of the stored picture
    std::vector<float> rotations;           // xyzw of each joint
    float root[3] = {};
};

struct ScanFrames {
    std::filesystem::path scan;  // folder of the scan
    std::vector<std::string> joints;
    std::vector<ComparedFrame> frames;  // those that have a pose
};

/** Whether the folder of an avatar says where its pictures are. */
bool hasScanFrames(const std::filesystem::path& run);

/** Reads frames.json and poses.json of a run. Errors name the file. CorruptData: damaged, or numbers out of bounds. */
Result<ScanFrames> readScanFrames(const std::filesystem::path& run);

}  // namespace dpl
