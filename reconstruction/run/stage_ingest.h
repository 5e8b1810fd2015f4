// SPDX-License-Identifier: Apache-2.0
// The stage ingest: checks the scan. The frame table is the scan after it.
#pragma once

#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/graph.h"

namespace dpl {

/** The result of the scan check. */
struct CheckedScan {
    std::string verdict;       // for people, several lines
    std::string check;         // a JSON object
    std::vector<bool> usable;  // of the frames; false: left out of training
    bool refused = false;
};

template <>
struct StageOf<CheckedScan> {
    static constexpr StageName kName{"ingest", 3};
    static constexpr const char* kPriors[] = {"input/cameras", "input/capture"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<CheckedScan> read(StageInputs& in, const std::filesystem::path& folder);
};

/** Stages use parts of the table and list their hashes. */
template <>
struct StageOf<FrameTable> {
    static constexpr StageName kName{"frames", 1};
    static Status inputs(StageInputs& in);
    static Result<FrameTable> compute(StageInputs& in);
};

}  // namespace dpl
