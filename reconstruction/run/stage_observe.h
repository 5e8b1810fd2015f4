// SPDX-License-Identifier: Apache-2.0
// The scan as it was read, and with what networks find in its pictures where it lacks keypoints, labels or masks.
#pragma once

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/graph.h"

namespace dpl {

/** The scan as its folder states it. */
struct ReadScan {
    Scan scan;
    std::vector<FrameHashes> hashes;  // of the frames
    std::string hash;                 // hashOfScan()
    std::filesystem::path networks;   // folder of those that look at it; empty: none
};

template <>
struct StageOf<ReadScan> {
    static constexpr StageName kName{"read", 1};
    static Status inputs(StageInputs& in);
    static Result<ReadScan> compute(StageInputs& in);
};

/** What the networks found: files that withObservations() takes. */
struct Observations {
    std::filesystem::path folder;
};

template <>
struct StageOf<Observations> {
    static constexpr StageName kName{"observe", 7};
    static constexpr const char* kPriors[] = {"input/cameras", "input/capture", "input/observe"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<Observations> read(StageInputs& in, const std::filesystem::path& folder);
};

/** The scan with keypoints and masks: its own, or those that were found. */
struct SeenScan {
    Scan scan;
    std::vector<FrameHashes> hashes;
    std::filesystem::path found;  // folder of found files; empty: the scan's own are used
};

template <>
struct StageOf<SeenScan> {
    static constexpr StageName kName{"seen", 1};
    static Status inputs(StageInputs& in);
    static Result<SeenScan> compute(StageInputs& in);
};

}  // namespace dpl
