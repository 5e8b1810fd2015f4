// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/project.h"

namespace dpl {

void addProject(FramePlan& plan, const FrameIds& ids) {
    if (ids.general) {
        plan.compute("splat.project", ids.ofViews("project.general"))
            .uniform(ids.frame)
            .reads(ids.splats)
            .writes(ids.projected, ids.visibility)
            .updates(ids.counts)
            .push(gpu::SplatPush{ids.splatCount, ids.allGroups, ids.firstGroup, ids.firstSplat, ids.drawn})
            .groups(ids.groupCount);
        plan.compute("splat.colour", ids.ofColour("colour.general"))
            .uniform(ids.frame)
            .reads(ids.splats, ids.sh)
            .updates(ids.projected)
            .push(gpu::ColourPush{ids.splatCount, ids.firstSplat})
            .threads(ids.splatCount);
        return;
    }
    plan.compute("splat.project", ids.ofColour("project"))
        .uniform(ids.frame)
        .reads(ids.splats, ids.triangleFrames)
        .writes(ids.projected)
        .updates(ids.visibility)
        .push(ids.codesPush())
        .groupsFrom(ids.counts, offsetof(gpu::FrameCounts, chunkGroupsX));
}

}  // namespace dpl
