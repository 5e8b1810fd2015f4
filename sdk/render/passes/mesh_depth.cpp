// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/mesh_depth.h"

#include <bit>
#include <limits>

namespace dpl {

void addMeshDepth(FramePlan& plan, const FrameIds& ids) {
    if (ids.drawn == 0) plan.fill("mesh.clear", ids.meshDepth, std::bit_cast<uint32_t>(std::numeric_limits<float>::infinity()));
    if (ids.triangleCount == 0) return;
    plan.compute("mesh.depth", "mesh.depth")
        .uniform(ids.frame)
        .reads(ids.triangles, ids.posed)
        .updates(ids.meshDepth)
        .push(gpu::MeshDepthPush{ids.triangleCount, ids.viewCount, ids.widthPx, ids.heightPx})
        .threads(ids.triangleCount);
}

}  // namespace dpl
