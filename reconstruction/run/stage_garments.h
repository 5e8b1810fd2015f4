// SPDX-License-Identifier: Apache-2.0
// The stage garments: makes the layers of the clothed subject from the fitted body, masks and labels of the still training frames. Without
// labels, or without layers in the settings, the result is one layer.
#pragma once

#include "reconstruction/run/graph.h"
#include "reconstruction/subject/garments/clothed_mesh.h"

namespace dpl {

/** The clothed subject as layers. */
struct GarmentLayers {
    ClothedMesh clothed;
    std::vector<EvidenceData> decided;  // which labels became layers, and why
};

template <>
struct StageOf<GarmentLayers> {
    static constexpr StageName kName{"garments", 12};
    static constexpr const char* kPriors[] = {"input/cameras", "input/capture", "subject/garments", "subject/surface"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<GarmentLayers> read(StageInputs& in, const std::filesystem::path& folder);
};

}  // namespace dpl
