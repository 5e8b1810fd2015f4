// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/triangles.h"

namespace dpl {

void addTriangles(FramePlan& plan, const FrameIds& ids) {
    plan.compute("pose.triangles", ids.ofViews("triangles"))
        .uniform(ids.frame)
        .reads(ids.triangles, ids.posed)
        .writes(ids.triangleFrames)
        .updates(ids.counts)
        .push(gpu::TrianglePush{ids.triangleCount})
        .threads(ids.triangleCount);
}

}  // namespace dpl
