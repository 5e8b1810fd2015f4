// SPDX-License-Identifier: Apache-2.0
// The first part of a reconstruction alone: cameras of a scan that brings none, and their errors where the truth is known.
#pragma once

#include <filesystem>
#include <string>

#include "reconstruction/run/progress.h"
#include "sdk/core/result.h"

namespace dpl {

struct FindCamerasOptions {
    std::filesystem::path scan;
    std::filesystem::path out;    // as of reconstruct(), which then does not repeat the stage
    std::filesystem::path truth;  // a metric scan with the true cameras of frames with the same names; empty: none
    double heightM = 0;           // of the subject; 0: unknown
};

/** Returns a few lines for the terminal. Cameras that a scan brings are checked and, if bad, repaired. Errors as of reconstruct(). */
Result<std::string> findCameras(const FindCamerasOptions& options, Progress& progress);

}  // namespace dpl
