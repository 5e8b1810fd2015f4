// SPDX-License-Identifier: Apache-2.0
// The stage cameras: finds the cameras of a scan that brings none, and repairs those of one that brings bad ones.
#pragma once

#include "reconstruction/input/capture/scan.h"
#include "reconstruction/run/cameras_file.h"
#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/graph.h"

namespace dpl {

/** The cameras of a scan that has none. */
struct SolvedScan {
    FoundCameras found;
    std::filesystem::path log;  // of COLMAP
};

template <>
struct StageOf<SolvedScan> {
    static constexpr StageName kName{"cameras", 2};
    static constexpr const char* kPriors[] = {"input/cameras", "input/capture"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<SolvedScan> read(StageInputs& in, const std::filesystem::path& folder);
};

/** Better cameras for a scan whose keypoints raise doubt; none where the pictures agree with its own. */
struct RepairedScan {
    FoundCameras found;
};

template <>
struct StageOf<RepairedScan> {
    static constexpr StageName kName{"cameras", 2};
    static constexpr const char* kPriors[] = {"input/cameras", "input/capture"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<RepairedScan> read(StageInputs& in, const std::filesystem::path& folder);
};

/** The scan with cameras: its own, found or repaired ones. Frames that got none are dropped. The verdict goes to the progress; when it
 *  refuses, it is the error. */
struct PlacedScan {
    Scan scan;
    std::vector<FrameHashes> hashes;
    bool camerasFound = false;  // by this run
};

template <>
struct StageOf<PlacedScan> {
    static constexpr StageName kName{"placed", 1};
    static Status inputs(StageInputs& in);
    static Result<PlacedScan> compute(StageInputs& in);
};

}  // namespace dpl
