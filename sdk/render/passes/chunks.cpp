// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/chunks.h"

namespace dpl {

void addChunks(FramePlan& plan, const FrameIds& ids) {
    plan.compute("chunks.mark", "chunks.mark")
        .reads(ids.splats, ids.triangleFrames)
        .writes(ids.visibility)
        .push(ids.codesPush())
        .threads(ids.groupCount);
    plan.compute("chunks.list", "chunks.list")
        .updates(ids.visibility, ids.counts)
        .push(gpu::ChunkPush{ids.groupCount, ids.allGroups, ids.firstGroup})
        .groups(1);
}

}  // namespace dpl
