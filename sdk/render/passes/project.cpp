#include "sdk/render/passes/project.h"

namespace dpl {

void addProject(FramePlan& plan, const FrameIds& ids) {
    plan.compute("splat.project", "project")
        .uniform(ids.frame)
        .reads(ids.splats, ids.triangleFrames)
        .writes(ids.projected)
        .updates(ids.visibility)
        .push(gpu::SplatPush{ids.splatCount, ids.viewCount, ids.chunkCount()})
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, chunkGroupsX));
}

void addColour(FramePlan& plan, const FrameIds& ids) {
    const uint32_t stride = (ids.shDegree + 1) * (ids.shDegree + 1) * 3;
    plan.compute("splat.colour", "colour")
        .reads(ids.sh)
        .updates(ids.projected)
        .reads(ids.visibility)
        .push(gpu::ColourPush{ids.splatCount, ids.viewCount, ids.shDegree, stride, ids.chunkCount()})
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, chunkGroupsX));
}

}  // namespace dpl
