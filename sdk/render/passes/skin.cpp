// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/skin.h"

namespace dpl {

void addSkin(FramePlan& plan, const FrameIds& ids) {
    plan.compute("pose.skin", ids.corrected ? "skin.corrected" : "skin")
        .uniform(ids.frame)
        .reads(ids.palette, ids.vertices)
        .writes(ids.posed)
        .updates(ids.counts)
        .push(gpu::VertexPush{ids.vertexCount, 3 * ids.jointCount, ids.drawn})
        .threads(ids.vertexCount);
}

}  // namespace dpl
