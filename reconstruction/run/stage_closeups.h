// SPDX-License-Identifier: Apache-2.0
// The stage closeups: holds found masks of close-ups against the full-body pictures.
#pragma once

#include <set>

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/graph.h"

namespace dpl {

/** Close-ups whose found mask the full-body pictures contradict. */
struct CloseupMasks {
    std::filesystem::path folder;        // of their new masks: the hull of the full-body masks, or empty ones
    std::set<std::string> contradicted;  // names of frames
    size_t replaced = 0;                 // by the hull
};

template <>
struct StageOf<CloseupMasks> {
    static constexpr StageName kName{"closeups", 1};
    static constexpr const char* kPriors[] = {"input/cameras", "input/capture", "input/observe"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<CloseupMasks> read(StageInputs& in, const std::filesystem::path& folder);
};

/** The scan with everything that a run found for it. */
struct CompleteScan {
    Scan scan;
    std::vector<FrameHashes> hashes;
    bool camerasFound = false;
};

template <>
struct StageOf<CompleteScan> {
    static constexpr StageName kName{"complete", 1};
    static Status inputs(StageInputs& in);
    static Result<CompleteScan> compute(StageInputs& in);
};

}  // namespace dpl
