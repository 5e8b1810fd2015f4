// SPDX-License-Identifier: Apache-2.0
// Vertices that pose correctives must not move, because no picture tells how.
#pragma once

#include "reconstruction/training/trainer/trainable.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Binds every vertex of the body without a splat on any of its triangles, such as those deep below clothes, to one more node. That node
 *  stays zero, because no picture has a gradient on it. Does nothing to empty correctives. `correctives` belong to `mesh` and have room for
 *  a node. Without layers the whole mesh is the body. */
void holdBareVertices(const MeshData& mesh, const TrainableSplats& splats, PoseCorrectiveData& correctives);

}  // namespace dpl
