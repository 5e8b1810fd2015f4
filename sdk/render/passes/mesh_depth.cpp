// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/mesh_depth.h"

#include <bit>
#include <limits>

namespace dpl {

void addMeshDepth(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject) {
    if (subject.drawn == 0) plan.fill("mesh.clear", frame.meshDepth, std::bit_cast<uint32_t>(std::numeric_limits<float>::infinity()));
    if (subject.triangleCount == 0) return;
    plan.compute("mesh.depth", "mesh.depth")
        .uniform(subject.uniforms)
        .reads(subject.triangles, subject.posed)
        .updates(frame.meshDepth)
        .push(gpu::MeshDepthPush{subject.triangleCount, frame.viewCount, frame.widthPx, frame.heightPx})
        .threads(subject.triangleCount);
}

}  // namespace dpl
