// SPDX-License-Identifier: Apache-2.0
// The stage pose-fit: fits the poses of frames that were not trained on and changes nothing else (docs/reference/registration.md). It runs
// after package, so it cannot affect the avatar.
#pragma once

#include "reconstruction/output/package/poses_file.h"
#include "reconstruction/run/graph.h"

namespace dpl {

/** Poses of all frames. Those of validation and held-out frames are fitted to the finished avatar. */
struct FoundPoses {
    std::filesystem::path file;  // poses.json in the stage's folder
    PosesFile poses;
};

template <>
struct StageOf<FoundPoses> {
    static constexpr StageName kName{"pose-fit", 9};
    static constexpr const char* kPriors[] = {"input/cameras",   "input/capture",        "subject/garments",
                                              "subject/surface", "training/correctives", "training/trainer"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<FoundPoses> read(StageInputs& in, const std::filesystem::path& folder);
};

}  // namespace dpl
