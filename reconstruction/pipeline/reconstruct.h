// SPDX-License-Identifier: Apache-2.0
// From a scan folder to an avatar: the whole chain of stages.
//
//   ingest → body-fit → surface → garments → co-optimise → evidence → package → pose-fit → report
#pragma once

#include <filesystem>
#include <string>

#include "reconstruction/pipeline/progress.h"
#include "sdk/core/result.h"

namespace dpl {

enum class Preset : uint8_t { Draft, Standard, High };

struct ReconstructOptions {
    std::filesystem::path scan;    // scan folder, nerfstudio or COLMAP folder
    std::filesystem::path out;     // made if absent
    std::filesystem::path body;    // glTF body; empty: the built-in one
    std::filesystem::path models;  // ONNX networks for keypoints and labels; empty: only what the scan brings
    Preset preset = Preset::Standard;
    double timeBudgetMinutes = 0;  // 0: the preset's own step counts
    uint32_t steps = 0;            // 0: the preset's; otherwise exactly this many training steps
    uint64_t seed = 1;
    bool trueBody = false;     // measuring only: shape and poses from the scan's truth.json instead of the body fit
    uint32_t threadCount = 0;  // 0: one a core; results do not depend on it
};

struct ReconstructResult {
    std::filesystem::path avatar;  // OUT/avatar.glb
    std::filesystem::path poses;   // OUT/poses.json
    std::filesystem::path report;  // OUT/report.html
    std::string summary;           // two lines for the terminal
};

/** Runs or continues a reconstruction. Only this function writes under `out`. Errors name the stage, the file and the remedy;
 *  Code::Cancelled after Ctrl-C, when everything finished so far is kept. */
Result<ReconstructResult> reconstruct(const ReconstructOptions& options, Progress& progress);

}  // namespace dpl
