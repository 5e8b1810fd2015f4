// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/seen_backs.h"

#include <atomic>
#include <numbers>

#include "reconstruction/subject/surface/mesh_raster.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "reconstruction/subject/surface/posed_positions.h"

namespace dpl {
namespace {

constexpr uint32_t kSidePx = 384;  // about 6 mm a pixel
constexpr uint32_t kAzimuths = 8;
constexpr double kElevations[] = {-0.25, 0.3};  // radians; from below too: under hems
constexpr uint32_t kLeastPixels = 3;            // of a back, over all views: fewer are edges seen along their plane

}  // namespace

std::vector<uint8_t> seenBacks(std::span<const JointData> joints, const MeshData& mesh, std::span<const Pose> poses, Jobs& jobs) {
    std::vector<uint8_t> seen(mesh.triangles.size(), 0);
    if (mesh.layers.size() < 2) return seen;
    const size_t first = mesh.layers.front().firstTriangle + mesh.layers.front().triangleCount;
    std::vector<std::atomic<uint32_t>> pixels(mesh.triangles.size());
    std::vector<Vec3f> posed;
    for (const Pose& pose : poses) {
        posedPositions(joints, mesh, pose, jobs, posed);
        Vec3f low(1e30f), high(-1e30f);
        for (const Vec3f& p : posed) low = glm::min(low, p), high = glm::max(high, p);
        jobs.forBlocks(kAzimuths * std::size(kElevations), [&](size_t view, uint32_t) {
            const double azimuth = 2 * std::numbers::pi * double(view % kAzimuths) / kAzimuths;
            const Camerad camera = orbitBox(low, high, azimuth, kElevations[view / kAzimuths], kSidePx);
            const Vec3f eye(camera.eye());
            for (const uint32_t t : rasteriseMesh(posed, mesh.triangles, camera).triangle) {
                if (t == kNoTriangle || t < first) continue;
                const Triangle& c = mesh.triangles[t];
                const Vec3f normal = glm::cross(posed[c.y] - posed[c.x], posed[c.z] - posed[c.x]);
                if (glm::dot(normal, eye - posed[c.x]) < 0) pixels[t].fetch_add(1, std::memory_order_relaxed);
            }
        });
    }
    for (size_t t = first; t < seen.size(); ++t) seen[t] = pixels[t].load() >= kLeastPixels;
    return seen;
}

}  // namespace dpl
