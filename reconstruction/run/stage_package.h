// SPDX-License-Identifier: Apache-2.0
// The stage package. The evidence decides which parts go into the file. What remains makes up for pose correctives that do not (trainedOn),
// a short polish runs on the decoded avatar, splats that stand free of the person go, the body's expressions are added, and the avatar is
// encoded with the capture map.
#pragma once

#include "reconstruction/run/graph.h"

namespace dpl {

struct Package {
    std::vector<uint8_t> bytes;  // of avatar.glb
};

template <>
struct StageOf<Package> {
    static constexpr StageName kName{"package", 11};
    static constexpr const char* kPriors[] = {"input/cameras",   "input/capture",        "subject/body",    "subject/garments",
                                              "subject/surface", "training/correctives", "training/trainer"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<Package> read(StageInputs& in, const std::filesystem::path& folder);
};

}  // namespace dpl
