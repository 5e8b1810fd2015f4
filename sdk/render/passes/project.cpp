#include "sdk/render/passes/project.h"

namespace dpl {

void addProject(FramePlan& plan, const FrameIds& ids) {
    plan.compute("splat.project", "project")
        .uniform(ids.frame)
        .reads(ids.splats, ids.triangleFrames)
        .writes(ids.projected, ids.sortDepth)
        .push(gpu::SplatPush{ids.splatCount, ids.viewCount})
        .threads(ids.splatCount);
}

void addColour(FramePlan& plan, const FrameIds& ids) {
    const uint32_t stride = (ids.shDegree + 1) * (ids.shDegree + 1) * 3;
    plan.compute("splat.colour", "colour")
        .reads(ids.sh)
        .updates(ids.projected)
        .push(gpu::ColourPush{ids.splatCount, ids.viewCount, ids.shDegree, stride})
        .threads(ids.splatCount);
}

}  // namespace dpl
