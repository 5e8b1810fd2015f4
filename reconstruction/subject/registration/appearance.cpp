// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/registration/appearance.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/subject/shape/spread_place.h"
#include "reconstruction/subject/surface/posed_positions.h"
#include "sdk/core/percentile.h"
#include "sdk/math/projection.h"

namespace dpl {
namespace {

constexpr double kHiddenM = 0.015;  // a point farther behind the drawn surface is hidden
constexpr double kMinCosine = 0.3;  // between normal and line of sight
constexpr size_t kMinPictures = 3;
constexpr double kSigmaPerDeviation = 1.4826;  // of a normal distribution

Vec3d placeOf(const MeshData& mesh, const std::vector<Vec3f>& positions, const MeshPoint& p) {
    const Triangle& t = mesh.triangles[p.triangle];
    return double(1 - p.uv.x - p.uv.y) * Vec3d(positions[t.x]) + double(p.uv.x) * Vec3d(positions[t.y]) +
           double(p.uv.y) * Vec3d(positions[t.z]);
}

}  // namespace

std::vector<MeshPoint> spreadPoints(const MeshData& mesh, size_t count) {
    std::vector<double> area;
    double total = 0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a(mesh.restPositions[t.x]), b(mesh.restPositions[t.y]), c(mesh.restPositions[t.z]);
        area.push_back(glm::length(glm::cross(b - a, c - a)));
        total += area.back();
    }
    std::vector<MeshPoint> points;
    const double step = total / double(std::max<size_t>(count, 1));
    double sum = 0, next = 0.5 * step;
    for (uint32_t t = 0; t < area.size() && step > 0; ++t)
        for (sum += area[t]; next <= sum; next += step) points.push_back({t, Vec2f(spreadPlace(0, uint32_t(points.size() + 1)))});
    return points;
}

std::vector<DrawnMesh> drawMesh(std::span<const JointData> joints, const MeshData& mesh, std::span<const Pose> poses,
                                std::span<const Camerad> cameras, Jobs& jobs) {
    std::vector<DrawnMesh> drawn(poses.size());
    for (size_t i = 0; i < poses.size(); ++i) posedPositions(joints, mesh, poses[i], jobs, drawn[i].positions);
    jobs.forBlocks(poses.size(),
                   [&](size_t i, uint32_t) { drawn[i].raster = rasteriseMesh(drawn[i].positions, mesh.triangles, cameras[i]); });
    return drawn;
}

std::vector<SeenPoint> seenPoints(const MeshData& mesh, std::span<const MeshPoint> points, const DrawnMesh& drawn, const Camerad& camera) {
    std::vector<SeenPoint> seen;
    const Vec3d eye = camera.eye();
    for (uint32_t i = 0; i < points.size(); ++i) {
        const Triangle& t = mesh.triangles[points[i].triangle];
        const Vec3d place = placeOf(mesh, drawn.positions, points[i]), view = camera.toView(place);
        if (!(view.z > kNearM)) continue;
        const Vec2d px = camera.pixelOf(view);
        if (!(px.x >= 0 && px.y >= 0 && px.x < camera.widthPx && px.y < camera.heightPx)) continue;
        if (view.z > drawn.raster.depthM[size_t(px.y) * camera.widthPx + size_t(px.x)] + kHiddenM) continue;
        const Vec3d a(drawn.positions[t.x]), b(drawn.positions[t.y]), c(drawn.positions[t.z]);
        const Vec3d normal = glm::cross(b - a, c - a), toEye = eye - place;
        if (!(glm::dot(normal, toEye) > kMinCosine * glm::length(normal) * glm::length(toEye))) continue;
        seen.push_back({i, px});
    }
    return seen;
}

std::vector<PointContrast> gatherContrast(size_t pointCount, std::span<const StillContrast> stills) {
    std::vector<std::vector<Vec3d>> values(pointCount);
    for (const StillContrast& still : stills)
        for (const SeenPoint& seen : still.seen) {
            Vec3d value, dx, dy;
            if (still.image->isInside(seen.px) && still.image->sample(seen.px, value, dx, dy)) values[seen.point].push_back(value);
        }
    std::vector<PointContrast> contrast(pointCount);
    std::vector<double> channel;
    for (size_t i = 0; i < pointCount; ++i) {
        if (values[i].size() < kMinPictures) continue;
        PointContrast& out = contrast[i];
        out.known = true;
        double variance = 0;
        for (int a = 0; a < 3; ++a) {
            channel.clear();
            for (const Vec3d& v : values[i]) channel.push_back(v[a]);
            out.median[a] = percentile(channel, 0.5);
            for (double& v : channel) v = std::abs(v - out.median[a]);
            const double deviation = kSigmaPerDeviation * percentile(channel, 0.5);
            variance += deviation * deviation / 3;
        }
        out.spread = std::sqrt(variance);
    }
    return contrast;
}

}  // namespace dpl
