#include "sdk/render/passes/project.h"

namespace dpl {

void addProject(FramePlan& plan, const FrameIds& ids) {
    if (ids.general) {
        plan.compute("splat.project", "project.general")
            .uniform(ids.frame)
            .reads(ids.splats)
            .writes(ids.projected, ids.visibility)
            .updates(ids.counts)
            .push(gpu::SplatPush{ids.splatCount, ids.viewCount})
            .threads(ids.splatCount);
        return;
    }
    plan.compute("splat.project", "project")
        .uniform(ids.frame)
        .reads(ids.splats, ids.triangleFrames)
        .writes(ids.projected)
        .updates(ids.visibility)
        .push(ids.codesPush())
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, chunkGroupsX));
}

void addColour(FramePlan& plan, const FrameIds& ids) {
    if (ids.general) {
        const gpu::ColourPush push{ids.splatCount, ids.viewCount, ids.shDegree, (ids.shDegree + 1) * (ids.shDegree + 1) * 3};
        plan.compute("splat.colour", "colour.general").uniform(ids.frame).reads(ids.splats, ids.sh).updates(ids.projected).push(push).threads(ids.splatCount);
        return;
    }
    plan.compute("splat.colour", "colour")
        .reads(ids.splats, ids.sh)
        .updates(ids.projected)
        .reads(ids.visibility)
        .push(ids.codesPush())
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, chunkGroupsX));
}

}  // namespace dpl
