// SPDX-License-Identifier: Apache-2.0
// Scores a finished avatar on the frames of a scan.
#pragma once

#include <filesystem>
#include <string>

#include "reconstruction/run/progress.h"
#include "sdk/core/result.h"

namespace dpl {

struct EvaluateOptions {
    std::filesystem::path scan, avatar;
    std::filesystem::path poses;  // poses.json of the reconstruction; empty: beside the avatar
    std::filesystem::path out;    // folder for report.html and report.json; empty: none
    std::filesystem::path web;    // as ReconstructOptions::web, for the report in `out`
    std::filesystem::path lpips;  // weights for LPIPS by a published protocol (docs/reference/neuman.md); empty: none
    bool ladder = false;          // replace stages by the truth in turn
    uint32_t threadCount = 0;     // 0: one a core; results do not depend on it
};

/** Scores the avatar as the report of its reconstruction does, and returns a summary for the terminal. Reads the avatar and poses.json and
 *  changes neither. Errors name the file and the remedy. */
Result<std::string> evaluateAvatar(const EvaluateOptions& options, Progress& progress);

}  // namespace dpl
