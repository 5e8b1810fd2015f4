#include "sdk/render/passes/draw.h"

namespace dpl {

DrawPipelineDesc drawPipelineOf(const FrameIds& ids, uint32_t samples) {
    const std::string fragment = std::string("draw.frag") + (ids.depth ? ".depth" : "") + (ids.sceneDepth ? ".scene" : "");
    return {ids.layered ? "draw.vert.multiview" : "draw.vert.instances", fragment, ids.viewCount, ids.layered, ids.depth, ids.halfColour, samples, Topology::List};
}

void addDraw(FramePlan& plan, const FrameIds& ids) {
    auto draw = plan.draw("draw.splats", drawPipelineOf(ids, ids.samples), ids.target);
    draw.reads(ids.counts, ids.pairs, ids.projected);
    if (ids.sceneDepth) draw.reads(ids.scene);
    draw.push(gpu::DrawPush{float(ids.widthPx), float(ids.heightPx), ids.viewCount, ids.layered ? 1 : ids.viewCount})
        .argsFrom(ids.counts, offsetof(gpu::FrameCounts, drawVertices));
}

}  // namespace dpl
