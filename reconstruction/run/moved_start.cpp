// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/moved_start.h"

#include <algorithm>

#include "reconstruction/subject/shape/implicit_mesh.h"
#include "reconstruction/subject/surface/fit_surface.h"
#include "reconstruction/training/correctives/motion_model.h"
#include "sdk/avatar/motion_state.h"
#include "sdk/core/evenly_spaced.h"

namespace dpl {
namespace {

constexpr size_t kLeastViews = 12, kMostViews = 48;
constexpr double kHasMoved = 0.99;
// Wide smoothing: a hull knows a hem's width and no fold. A subject does not sway here, but its registered poses are off by as much.
const SurfaceFitSettings kFit{.startSmoothingM = 0.12, .endSmoothingM = 0.06, .levels = 4, .roundsPerLevel = 4, .maxOffsetM = 0.06};

Result<std::vector<SurfaceView>> movedViews(const CoOptimiseInput& input) {
    const MotionModeData& motion = input.correctives.motion;
    std::vector<const TrainFrame*> moved;
    for (const TrainFrame& frame : input.frames)
        if (frame.kind == FrameKind::Dynamic && stateOf(motion, frame.pose).held[hasMoved(motion)] > kHasMoved) moved.push_back(&frame);
    std::vector<SurfaceView> views;
    if (moved.size() < kLeastViews) return views;
    for (const TrainFrame* frame : evenlySpaced(moved, kMostViews)) {
        DPL_TRY(const auto picture, frame->picture.get());
        const auto& mask = picture->mask.pixels;
        if (std::any_of(mask.begin(), mask.end(), isPerson)) views.push_back({frame->camera, picture->mask, frame->pose});
    }
    return views;
}

}  // namespace

Result<MovedStart> startMovedColumn(CoOptimiseInput& input, Jobs& jobs) {
    PoseCorrectiveData& c = input.correctives;
    const MeshData& mesh = input.mesh;
    if (c.motion.empty() || mesh.layers.size() < 2) return MovedStart{};
    DPL_TRY(const std::vector<SurfaceView> views, movedViews(input));
    if (views.empty()) return MovedStart{};
    DPL_TRY(const SurfaceFit fit, fitSurface(mesh, input.joints, views, kFit, jobs));
    const std::vector<Vec3f> normals = vertexNormals(mesh.restPositions, mesh.triangles);
    std::vector<Vec4d> sums(c.nodeCount, Vec4d(0));  // weighted offsets, weight
    for (size_t v = mesh.layers.front().vertexCount; v < fit.restOffsets.size(); ++v) {
        const Vec3f outward = glm::dot(fit.restOffsets[v], normals[v]) * normals[v];  // an outline does not show a slide along the surface
        for (int k = 0; k < 4; ++k) sums[c.nodeIndices[v][k]] += double(c.nodeWeights[v][k]) * Vec4d(Vec3d(outward), 1);
    }
    const std::vector<uint32_t> heard = motionReachingNodes(input.joints, mesh, c);
    for (size_t n = 0; n < c.nodeCount; ++n)
        if (heard[n] != 0 && sums[n].w > 0) c.nodes[n * c.columnCount() + c.modeCount] = Vec4f(Vec3f(Vec3d(sums[n]) / sums[n].w), 0);
    return MovedStart{views.size(), fit.meanIouBefore, fit.meanIouAfter};
}

}  // namespace dpl
