// SPDX-License-Identifier: Apache-2.0
// The stage register: registers training frames to their pictures, and places the others by their keypoints alone.
#pragma once

#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/graph.h"

namespace dpl {

struct RegisteredPoses {
    PoseColumn<PoseSource::Registered> poses;                      // those of held-out frames from their keypoints alone
    std::vector<std::shared_ptr<const PosePrecision>> precisions;  // of `poses`
};

template <>
struct StageOf<RegisteredPoses> {
    static constexpr StageName kName{"register", 9};
    static constexpr const char* kPriors[] = {"input/cameras",    "input/capture",        "subject/body",
                                              "subject/garments", "subject/registration", "subject/surface"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<RegisteredPoses> read(StageInputs& in, const std::filesystem::path& folder);
};

/** The frames of a split in their registered poses, with precisions. The stage has pulled frame table, metric cameras and these poses. */
Result<FrameSet> registeredFrames(StageInputs& in, Split split);

}  // namespace dpl
