// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/draw.h"

namespace dpl {

DrawPipelineDesc drawPipelineOf(const FrameIds& ids, uint32_t samples) {
    const std::string fragment = std::string("draw.frag") + (ids.depth ? ".depth" : "") + (ids.sceneDepth ? ".scene" : "");
    return {
        ids.multiview ? "draw.vert.multiview" : "draw.vert", fragment, ids.viewCount, ids.multiview, ids.depth, samples, Topology::List};
}

void addDraw(FramePlan& plan, const FrameIds& ids) {
    for (uint32_t view = 0; view < (ids.multiview ? 1 : ids.viewCount); ++view) {
        auto draw = plan.draw("draw.splats", drawPipelineOf(ids, ids.samples), ids.target, view);
        draw.reads(ids.counts, ids.pairs, ids.projected);
        if (ids.sceneDepth) draw.reads(ids.scene);
        draw.push(gpu::DrawPush{float(ids.widthPx), float(ids.heightPx), ids.allSplats, view})
            .argsFrom(ids.counts, offsetof(gpu::FrameCounts, drawVertices));
    }
}

}  // namespace dpl
