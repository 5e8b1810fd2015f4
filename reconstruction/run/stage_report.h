// SPDX-License-Identifier: Apache-2.0
// The stage report: draws the finished avatar.glb with the public SDK and scores it on held-out frames. Its figures do not affect the
// avatar.
#pragma once

#include "reconstruction/run/graph.h"

namespace dpl {

/** report.html, report.json and portrait.jpg (empty: no picture) in the stage's folder. */
struct ReportFiles {
    std::filesystem::path folder;
    std::string summary;  // figures, lines for the terminal
    std::string words;    // sentences for who filmed
    std::string word;     // "Good", "Usable", "Film again"
};

template <>
struct StageOf<ReportFiles> {
    static constexpr StageName kName{"report", 22};
    static constexpr const char* kPriors[] = {"input/cameras",   "input/capture",        "subject/body",    "subject/garments",
                                              "subject/surface", "training/correctives", "training/trainer"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<ReportFiles> read(StageInputs& in, const std::filesystem::path& folder);
};

}  // namespace dpl
