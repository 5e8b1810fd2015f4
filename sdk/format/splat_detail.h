// What level of detail needs to know of splats, made when they are loaded.
#pragma once

#include <span>
#include <vector>

#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"

namespace dpl {

/** Fills splats.groups (12 bytes a half-chunk). Parents must lie within the mesh. */
void measureGroups(const MeshData& mesh, CodedSplats& splats);

/** kSplatGroupSize neighbours of general splats, the last ones fewer. */
struct GeneralGroup {
    Vec3f middle{0}, reach{0};    // of the box about their centres; half its size
    SplatGroup detail;
};

/** Of general splats in an order that keeps neighbours together (spatialOrder); order[new] = old. */
std::vector<GeneralGroup> measureGroups(const StaticSplatData& splats, std::span<const uint32_t> order);

}  // namespace dpl
