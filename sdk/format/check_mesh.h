// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** What everybody who poses a mesh relies on: joint indices and weights for every vertex, joints below jointCount (a slot of weight 0 may
 * name any), and triangles that name vertices of the mesh. An empty mesh passes. InvalidArgument: names the first vertex or triangle. */
Status checkMesh(const MeshData& mesh, size_t jointCount);

/** InvalidArgument for the first rest position that is not finite. */
Status checkFinite(const MeshData& mesh);

/** InvalidArgument unless the layers tile vertices and triangles in order, share no vertices and have a known role. Call checkMesh() first.
 */
Status checkLayers(const MeshData& mesh);

}  // namespace dpl
