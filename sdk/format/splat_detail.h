// What level of detail needs to know of splats, made when they are loaded.
#pragma once

#include "sdk/format/avatar_data.h"
#include "sdk/format/coded_splats.h"

namespace dpl {

/** Fills splats.groups (12 bytes a half-chunk). Parents must lie within the mesh. */
void measureGroups(const MeshData& mesh, CodedSplats& splats);

}  // namespace dpl
