// SPDX-License-Identifier: Apache-2.0
// The roots of the graph: what the user asked for, and the numbers that follow from it. A run is given the request with put().
#pragma once

#include "reconstruction/run/graph.h"
#include "reconstruction/run/preset.h"
#include "reconstruction/run/reconstruct.h"

namespace dpl {

struct RunRequest {
    std::filesystem::path scan;  // the folder to read; of a capture, that of its import
    ReconstructOptions options;
};

template <>
struct StageOf<RunRequest> {
    static constexpr StageName kName{"request", 1};
    static Status inputs(StageInputs&) { return fail(Code::Internal, "nobody gave the run a request"); }
};

/** The settings of the request for this scan. */
template <>
struct StageOf<RunSettings> {
    static constexpr StageName kName{"settings", 1};
    static Status inputs(StageInputs& in);
    static Result<RunSettings> compute(StageInputs& in);
};

/** Makes avatar, poses and report of a run that has its request, and writes them into the output folder. */
Result<ReconstructResult> completeRun(Run& run);

}  // namespace dpl
