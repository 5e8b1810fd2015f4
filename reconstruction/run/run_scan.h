// SPDX-License-Identifier: Apache-2.0
// A scan as a finished reconstruction used it, for drawing and scoring its frames again.
#pragma once

#include <filesystem>
#include <vector>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/output/package/poses_file.h"

namespace dpl {

/** cameras.json, which a reconstruction writes beside poses.json when it found or repaired the scan's cameras. */
std::filesystem::path camerasBeside(const std::filesystem::path& posesPath);

struct RunScan {
    Scan scan;                     // with the run's cameras and splits; frames without a camera are left out
    std::vector<Camerad> cameras;  // of the frames, in metres
    PosesFile poses;               // one a frame, in the scan's order
};

/** Reads the scan, its poses, and the cameras beside them. Errors name the file: a frame without a pose, no length of the world's unit. */
Result<RunScan> readRunScan(const std::filesystem::path& scan, const std::filesystem::path& posesPath);

}  // namespace dpl
