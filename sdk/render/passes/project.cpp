#include "sdk/render/passes/project.h"

namespace dpl {

void addProject(FramePlan& plan, const FrameIds& ids) {
    if (ids.general) {
        plan.compute("splat.project", "project.general")
            .uniform(ids.frame)
            .reads(ids.splats)
            .writes(ids.projected, ids.sortDepth)
            .updates(ids.counts)
            .push(gpu::SplatPush{ids.splatCount, ids.viewCount})
            .threads(ids.splatCount);
        return;
    }
    plan.compute("splat.project", "project")
        .uniform(ids.frame)
        .reads(ids.splats, ids.triangleFrames)
        .writes(ids.projected, ids.sortDepth)
        .push(gpu::SplatPush{ids.splatCount, ids.viewCount})
        .threads(ids.splatCount);
}

void addColour(FramePlan& plan, const FrameIds& ids) {
    const uint32_t stride = (ids.shDegree + 1) * (ids.shDegree + 1) * 3;
    const gpu::ColourPush push{ids.splatCount, ids.viewCount, ids.shDegree, stride};
    if (ids.general) {
        plan.compute("splat.colour", "colour.general").uniform(ids.frame).reads(ids.splats, ids.sh).updates(ids.projected).push(push).threads(ids.splatCount);
        return;
    }
    plan.compute("splat.colour", ids.corrected ? "colour.lit" : "colour")
        .uniform(ids.frame)
        .reads(ids.splats, ids.triangleFrames, ids.sh)
        .updates(ids.projected)
        .push(push)
        .threads(ids.splatCount);
}

}  // namespace dpl
