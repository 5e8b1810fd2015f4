// SPDX-License-Identifier: Apache-2.0
// The stage co-optimise: binds splats to the layers and trains them with surface, poses and pose correctives.
#pragma once

#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/graph.h"
#include "reconstruction/run/preset.h"
#include "reconstruction/training/trainer/profile_steps.h"

namespace dpl {

struct Training {
    CoOptimiseResult result;
    uint32_t steps = 0;  // that it took; a time budget decides them
};

template <>
struct StageOf<Training> {
    static constexpr StageName kName{"co-optimise", 23};
    static constexpr const char* kPriors[] = {"input/cameras",        "input/capture",  "subject/garments", "subject/surface",
                                              "training/correctives", "training/light", "training/trainer"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<Training> read(StageInputs& in, const std::filesystem::path& folder);
    /** With a time budget the number of steps is a result, and with Kind::Auto the engine is: another run may have fitted in other steps,
     * or have found no GPU. */
    static Result<std::string> keyAfter(StageInputs& in, const std::filesystem::path& folder, const std::string& key);
};

/** How many steps of the training to measure; given to the run with put(). */
template <>
struct StageOf<ProfiledSteps> {
    static constexpr StageName kName{"profiled-steps", 1};
    static Status inputs(StageInputs&) { return fail(Code::Internal, "nobody said how many steps to measure"); }
};

/** The speed of the training that the run would do. Nothing is trained on. */
template <>
struct StageOf<ProfiledTraining> {
    static constexpr StageName kName{"profile-training", 1};
    static Status inputs(StageInputs& in);
    static Result<ProfiledTraining> compute(StageInputs& in);
};

/** The settings with the number of steps that training took. */
struct SettingsAfterTraining {
    RunSettings settings;
};

template <>
struct StageOf<SettingsAfterTraining> {
    static constexpr StageName kName{"settings-after-training", 1};
    static Status inputs(StageInputs& in);
    static Result<SettingsAfterTraining> compute(StageInputs& in);
};

}  // namespace dpl
