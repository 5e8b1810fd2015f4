// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/skin.h"

namespace dpl {

void addSkin(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject) {
    plan.compute("pose.skin", subject.corrected ? "skin.corrected" : "skin")
        .uniform(subject.uniforms)
        .reads(subject.palette, subject.vertices)
        .writes(subject.posed)
        .updates(frame.counts)
        .push(gpu::VertexPush{subject.vertexCount, 3 * subject.jointCount, subject.firstLight, subject.drawn})
        .threads(subject.vertexCount);
}

}  // namespace dpl
