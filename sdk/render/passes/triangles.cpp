// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/triangles.h"

namespace dpl {

void addTriangles(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject) {
    plan.compute("pose.triangles", frame.ofViews("triangles"))
        .uniform(subject.uniforms)
        .reads(subject.triangles, subject.posed)
        .writes(subject.triangleFrames)
        .updates(frame.counts)
        .push(gpu::TrianglePush{subject.triangleCount})
        .threads(subject.triangleCount);
}

}  // namespace dpl
