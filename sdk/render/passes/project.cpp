#include "sdk/render/passes/project.h"

namespace dpl {

void addProject(FramePlan& plan, const FrameIds& ids) {
    if (ids.general) {
        plan.compute("splat.project", ids.ofViews("project.general"))
            .uniform(ids.frame)
            .reads(ids.splats)
            .writes(ids.projected, ids.visibility)
            .updates(ids.counts)
            .push(gpu::SplatPush{ids.splatCount, ids.groupCount})
            .groups(ids.groupCount);
        const gpu::ColourPush push{ids.splatCount, ids.shDegree, (ids.shDegree + 1) * (ids.shDegree + 1) * 3};
        plan.compute("splat.colour", ids.ofViews("colour.general")).uniform(ids.frame).reads(ids.splats, ids.sh).updates(ids.projected).push(push).threads(ids.splatCount);
        return;
    }
    plan.compute("splat.project", ids.ofViews("project"))
        .uniform(ids.frame)
        .reads(ids.splats, ids.triangleFrames)
        .writes(ids.projected)
        .updates(ids.visibility)
        .push(ids.codesPush())
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, chunkGroupsX));
}

}  // namespace dpl
