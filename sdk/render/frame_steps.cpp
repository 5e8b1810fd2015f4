// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/frame_steps.h"

#include "sdk/render/passes/chunks.h"
#include "sdk/render/passes/compact.h"
#include "sdk/render/passes/draw.h"
#include "sdk/render/passes/mesh_depth.h"
#include "sdk/render/passes/project.h"
#include "sdk/render/passes/skin.h"
#include "sdk/render/passes/sort.h"
#include "sdk/render/passes/triangles.h"

namespace dpl {

void planFrame(FramePlan& plan, const FrameIds& frame, std::span<const SubjectIds> subjects, const TilePlan* tiles, BufferId finalCounts) {
    plan.fill("begin", frame.counts, 0);
    for (const SubjectIds& subject : subjects) {
        if (!subject.general && subject.vertexCount > 0 && (subject.splatCount > 0 || frame.meshDepth)) addSkin(plan, frame, subject);
        if (frame.meshDepth) addMeshDepth(plan, frame, subject);
    }
    for (const SubjectIds& subject : subjects) {
        if (subject.splatCount == 0) continue;
        if (!subject.general) {
            addTriangles(plan, frame, subject);
            addChunks(plan, frame, subject);
        }
        addProject(plan, frame, subject);
    }
    if (frame.allSplats > 0) {
        addCompact(plan, frame);
        addSort(plan, frame);
    } else {  // the draw has no vertices, because its arguments are zero, but still clears the target
        plan.fill("no pairs", frame.pairs, 0);
        plan.fill("no splats", frame.projected, 0);
    }
    if (tiles)
        addTiles(plan, frame, *tiles);
    else
        addDraw(plan, frame);
    plan.copy("counts", frame.counts, finalCounts);
}

}  // namespace dpl
