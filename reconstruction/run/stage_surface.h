// SPDX-License-Identifier: Apache-2.0
// The stage surface: offsets of the bare body with which its outline fills the masks.
#pragma once

#include "reconstruction/run/frame_table.h"
#include "reconstruction/run/graph.h"

namespace dpl {

struct FittedSurface {
    std::vector<Vec3f> restOffsets;  // V, rest pose, metres: from the shaped body to the clothed surface
    PoseColumn<PoseSource::Surface> poses;

    /** The body's mesh with these offsets. */
    MeshData clothed(const MeshData& body) const;
};

template <>
struct StageOf<FittedSurface> {
    static constexpr StageName kName{"surface", 2};
    static constexpr const char* kPriors[] = {"input/cameras", "input/capture", "subject/body", "subject/surface"};
    static Status inputs(StageInputs& in);
    static Status make(StageInputs& in, StageContext& context);
    static Result<FittedSurface> read(StageInputs& in, const std::filesystem::path& folder);
};

}  // namespace dpl
