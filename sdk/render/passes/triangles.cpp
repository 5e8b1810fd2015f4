#include "sdk/render/passes/triangles.h"

namespace dpl {

void addTriangles(FramePlan& plan, const FrameIds& ids) {
    plan.compute("pose.triangles", "triangles")
        .reads(ids.triangles, ids.posed)
        .writes(ids.triangleFrames)
        .push(gpu::TrianglePush{ids.triangleCount})
        .threads(ids.triangleCount);
}

}  // namespace dpl
