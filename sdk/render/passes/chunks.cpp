// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/chunks.h"

namespace dpl {

void addChunks(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject) {
    plan.compute("chunks.mark", "chunks.mark")
        .reads(subject.splats, subject.triangleFrames)
        .writes(frame.visibility)
        .push(frame.codesPush(subject))
        .threads(subject.groupCount);
    plan.compute("chunks.list", "chunks.list")
        .updates(frame.visibility, frame.counts)
        .push(gpu::ChunkPush{subject.groupCount, frame.allGroups, subject.firstGroup})
        .groups(1);
}

}  // namespace dpl
