// Projection: splats in, ProjectedSplat + tile box + depth key out, in blocks of kProjectBlock splats.
#include <algorithm>

#include "sdk/splat/project_kernel.h"

namespace dpl {
namespace {

constexpr uint32_t kPackAhead = 64;  // splats packed at a time when they come unpacked: 15 KB at SH degree 3, so it stays in L1

ProjectView viewOf(const Cameraf& camera, float kappaPx2, bool compensated, uint32_t samples = 1) {
    ProjectView v;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) v.rotation[r * 3 + c] = camera.viewFromWorldRotation[c][r];
    const JacobianClamp<float> limit(camera);
    const Vec3f eye = camera.eye();
    for (int k = 0; k < 3; ++k) v.translation[k] = camera.viewFromWorldTranslation[k], v.eye[k] = eye[k];
    v.fx = camera.fx, v.fy = camera.fy, v.cx = camera.cx, v.cy = camera.cy;
    v.width = float(camera.widthPx), v.height = float(camera.heightPx);
    v.minX = limit.minX, v.maxX = limit.maxX, v.minY = limit.minY, v.maxY = limit.maxY;
    v.kappaPx2 = kappaPx2 / float(samples);
    v.reachPx = samples > 1 ? kCoverageReachPx : 0;
    v.samples = samples;
    v.compensated = compensated;
    return v;
}

void store(float* out, const Vec3f& v) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }

/** One record a triangle, and an invalid one behind the last. */
const TriangleView* viewTriangles(Jobs& jobs, Scratch<TriangleView>& scratch, std::span<const TriangleFrame<float>> triangles,
                                  const Cameraf& camera) {
    TriangleView* out = scratch.resize(triangles.size() + 1);
    out[triangles.size()] = TriangleView{};
    const Vec3f eye = camera.eye();
    const Mat3f& turn = camera.viewFromWorldRotation;
    jobs.forRange(triangles.size(), 4096, [&](size_t begin, size_t end, uint32_t) {
        for (size_t i = begin; i < end; ++i) {
            const TriangleFrame<float>& t = triangles[i];
            TriangleView r{};
            if (t.valid) {
                const Mat3f restFromWorld = glm::transpose(t.worldFromRest);
                r.valid = 1;
                r.planeDot = glm::dot(t.normal, eye - t.v0);
                store(r.v0, camera.toView(t.v0));
                store(r.e1, turn * (t.v1 - t.v0)), store(r.e2, turn * (t.v2 - t.v0));
                store(r.f0, turn * t.f0), store(r.f1, turn * t.f1);
                store(r.rest0, restFromWorld * (t.v0 - eye));
                r.light0 = t.light.x, r.light1 = t.light.y - t.light.x, r.light2 = t.light.z - t.light.x;
                store(r.rest1, restFromWorld * (t.v1 - t.v0)), store(r.rest2, restFromWorld * (t.v2 - t.v0));
            }
            out[i] = r;
        }
    });
    return out;
}

/** Sizes the buffers, then runs body(task) for each block with everything but the packed groups filled in. */
template <class Body>
void forProjectBlocks(Jobs& jobs, SplatEngine::Buffers& buffers, const Cameraf& camera, const ProjectView& view, uint32_t count,
                      uint32_t shDegree, const TriangleView* triangles, size_t triangleCount, Body&& body) {
    const auto allowed = [](uint32_t size) { return size > 0 && size <= kMaxTargetPx; };
    const bool drawable = allowed(camera.widthPx) && allowed(camera.heightPx);
    buffers.widthPx = drawable ? camera.widthPx : 0, buffers.heightPx = drawable ? camera.heightPx : 0;
    if (!drawable) count = 0;
    // The kernel writes whole groups: room for the padding of the last one.
    const size_t padded = groupCount(count) * kGroupSplats;
    buffers.projected.resize(padded), buffers.boxes.resize(padded), buffers.rowScale.resize(padded);
    buffers.keys[0].resize(padded), buffers.values[0].resize(padded);
    buffers.splatCount = count;
    buffers.sortedFrame = false;
    buffers.samples = view.samples;
    buffers.blocks.resize((count + kProjectBlock - 1) / kProjectBlock);
    jobs.forRange(count, kProjectBlock, [&](size_t begin, size_t end, uint32_t) {
        BlockVisible visible;
        ProjectTask task{&view, nullptr, uint32_t(groupCount(end - begin)), uint32_t(begin), shDegree, triangles, uint32_t(triangleCount),
                         buffers.projected.data(), buffers.rowScale.data(), buffers.boxes.data(), buffers.keys[0].data() + begin,
                         buffers.values[0].data() + begin, &visible};
        body(task);
        buffers.blocks[begin / kProjectBlock] = visible;
    });
}

/** Packs a few splats at a time into the worker's cache and projects them. */
template <class Splats>
void projectUnpacked(const Splats& splats, ProjectTask task) {
    alignas(64) float packed[kPackAhead / kGroupSplats * kMaxGroupFloats];
    const size_t groupFloats = size_t(groupFields(task.triangles != nullptr, task.shDegree)) * kGroupSplats;
    uint32_t left = task.groups;
    task.packed = packed;
    while (left > 0) {
        task.groups = std::min(left, kPackAhead / kGroupSplats);
        for (uint32_t g = 0; g < task.groups; ++g) packGroup(splats, task.firstSplat + g * kGroupSplats, packed + g * groupFloats);
        projectGroups(task);
        task.firstSplat += task.groups * kGroupSplats;
        left -= task.groups;
    }
}

}  // namespace

void projectBound(Jobs& jobs, SplatEngine::Buffers& buffers, const BoundSplatView& splats,
                  std::span<const TriangleFrame<float>> triangles, const Cameraf& camera, float kappaPx2, bool compensated) {
    const ProjectView view = viewOf(camera, kappaPx2, compensated);
    const TriangleView* posed = viewTriangles(jobs, buffers.triangles, triangles, camera);
    forProjectBlocks(jobs, buffers, camera, view, usableCount(splats), splats.shDegree, posed, triangles.size(),
                     [&](const ProjectTask& task) { projectUnpacked(splats, task); });
}

void projectStatic(Jobs& jobs, SplatEngine::Buffers& buffers, const StaticSplatData& splats, const Cameraf& camera, float kappaPx2,
                   bool compensated) {
    const ProjectView view = viewOf(camera, kappaPx2, compensated);
    forProjectBlocks(jobs, buffers, camera, view, usableCount(splats), splats.shDegree, nullptr, 0,
                     [&](const ProjectTask& task) { projectUnpacked(splats, task); });
}

void projectPacked(Jobs& jobs, SplatEngine::Buffers& buffers, const PackedSplats& splats, std::span<const TriangleFrame<float>> triangles,
                   const Cameraf& camera, float kappaPx2, bool compensated, uint32_t samples) {
    const ProjectView view = viewOf(camera, kappaPx2, compensated, samples == kCoverageSamples ? kCoverageSamples : 1);
    const TriangleView* posed = splats.bound() ? viewTriangles(jobs, buffers.triangles, triangles, camera) : nullptr;
    const size_t groupFloats = size_t(groupFields(splats.bound(), splats.shDegree())) * kGroupSplats;
    forProjectBlocks(jobs, buffers, camera, view, splats.count(), splats.shDegree(), posed, triangles.size(), [&](ProjectTask task) {
        task.packed = splats.data() + task.firstSplat / kGroupSplats * groupFloats;
        projectGroups(task);
    });
}

}  // namespace dpl
