// SPDX-License-Identifier: Apache-2.0
#include "sdk/surface/ray_caster.h"

#include <algorithm>
#include <cmath>

#include "sdk/format/spatial_order.h"

namespace dpl {
namespace {

constexpr size_t kClusterTriangles = 64;

uint32_t mainJoint(const MeshData& mesh, uint32_t vertex) {
    const glm::u8vec4& weights = mesh.jointWeights[vertex];
    int most = 0;
    for (int k = 1; k < 4; ++k)
        if (weights[k] > weights[most]) most = k;
    return mesh.jointIndices[vertex][most];
}

/** A ray seen along itself: the axis that it follows most is z, and the others are sheared so that it stands at x = y = 0 (Woop, Benthin
 *  and Wald 2013). Neighbours compute the same number for their common edge, with opposite signs, so no ray slips between them. */
struct Sheared {
    Vec3d origin, shear;
    int x, y, z;

    explicit Sheared(const SurfaceRay& ray) : origin(ray.origin) {
        const Vec3d size = glm::abs(ray.direction);
        z = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
        x = (z + 1) % 3, y = (z + 2) % 3;
        shear = {ray.direction[x] / ray.direction[z], ray.direction[y] / ray.direction[z], 1 / ray.direction[z]};
    }
    /** x and y across the ray; z the distance along it. */
    Vec3d of(const Vec3f& p) const {
        const Vec3d q = Vec3d(p) - origin;
        return {q[x] - shear.x * q[z], q[y] - shear.y * q[z], shear.z * q[z]};
    }
    std::optional<RayHit> meet(const Vec3f& p, const Vec3f& q, const Vec3f& r) const {
        const Vec3d a = of(p), b = of(q), c = of(r);
        const double u = c.x * b.y - c.y * b.x, v = a.x * c.y - a.y * c.x, w = b.x * a.y - b.y * a.x;
        if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return std::nullopt;
        const double sum = u + v + w;
        if (!(sum != 0)) return std::nullopt;  // seen from its edge, or not finite
        const Vec3d shares = Vec3d(u, v, w) / sum;
        const double distance = shares.x * a.z + shares.y * b.z + shares.z * c.z;
        if (!(distance >= 0)) return std::nullopt;
        return RayHit{distance, 0, shares};
    }
};

}  // namespace

RayCaster::RayCaster(const MeshData& mesh) {
    std::vector<Vec3f> centres;
    for (const Triangle& t : mesh.triangles)
        centres.push_back((mesh.restPositions[t.x] + mesh.restPositions[t.y] + mesh.restPositions[t.z]) / 3.0f);
    numbers_ = spatialOrder(centres);
    std::stable_sort(numbers_.begin(), numbers_.end(),
                     [&](uint32_t a, uint32_t b) { return mainJoint(mesh, mesh.triangles[a].x) < mainJoint(mesh, mesh.triangles[b].x); });
    for (const uint32_t number : numbers_) corners_.push_back(mesh.triangles[number]);
    for (size_t begin = 0; begin < corners_.size();) {
        const uint32_t joint = mainJoint(mesh, corners_[begin].x);
        size_t end = begin;
        const size_t firstVertex = vertices_.size();
        for (; end < corners_.size() && end - begin < kClusterTriangles && mainJoint(mesh, corners_[end].x) == joint; ++end)
            for (int k = 0; k < 3; ++k) vertices_.push_back(corners_[end][k]);
        std::sort(vertices_.begin() + std::ptrdiff_t(firstVertex), vertices_.end());
        vertices_.erase(std::unique(vertices_.begin() + std::ptrdiff_t(firstVertex), vertices_.end()), vertices_.end());
        clusters_.push_back({uint32_t(end), uint32_t(vertices_.size())});
        begin = end;
    }
    boxes_.resize(clusters_.size());
}

void RayCaster::follow(std::span<const Vec3f> positions) {
    size_t v = 0;
    for (size_t i = 0; i < clusters_.size(); ++i) {
        Box box{Vec3f(INFINITY), Vec3f(-INFINITY)};
        for (; v < clusters_[i].vertices; ++v) {
            const Vec3f& p = positions[vertices_[v]];
            box.low = glm::min(box.low, p), box.high = glm::max(box.high, p);
        }
        boxes_[i] = box;
    }
}

std::optional<RayHit> RayCaster::cast(std::span<const Vec3f> positions, const SurfaceRay& ray, std::span<const uint8_t> leftOut) const {
    const Vec3d inverse = 1.0 / ray.direction;
    entered_.clear();
    for (size_t i = 0; i < boxes_.size(); ++i) {
        // A little larger, so that rounding here hides nothing.
        const Vec3d margin = 1e-6 * (1.0 + glm::abs(Vec3d(boxes_[i].low)) + glm::abs(Vec3d(boxes_[i].high)) + glm::abs(ray.origin));
        const Vec3d low = Vec3d(boxes_[i].low) - margin - ray.origin, high = Vec3d(boxes_[i].high) + margin - ray.origin;
        double in = 0, out = INFINITY;
        for (int axis = 0; axis < 3; ++axis) {
            if (ray.direction[axis] == 0) {
                if (low[axis] > 0 || high[axis] < 0) out = -1;
                continue;
            }
            const double a = low[axis] * inverse[axis], b = high[axis] * inverse[axis];
            in = std::max(in, std::min(a, b)), out = std::min(out, std::max(a, b));
        }
        if (in <= out) entered_.push_back({in, uint32_t(i)});
    }
    std::sort(entered_.begin(), entered_.end(), [](const Entry& a, const Entry& b) { return a.at < b.at; });
    const Sheared sheared(ray);
    std::optional<RayHit> nearest;
    for (const Entry& entry : entered_) {
        if (nearest && entry.at > nearest->distanceM) break;
        const uint32_t begin = entry.cluster == 0 ? 0 : clusters_[entry.cluster - 1].triangles;
        for (uint32_t t = begin; t < clusters_[entry.cluster].triangles; ++t) {
            if (!leftOut.empty() && leftOut[numbers_[t]]) continue;
            auto hit = sheared.meet(positions[corners_[t].x], positions[corners_[t].y], positions[corners_[t].z]);
            if (!hit) continue;
            hit->triangle = numbers_[t];
            if (!nearest || hit->distanceM < nearest->distanceM ||
                (hit->distanceM == nearest->distanceM && hit->triangle < nearest->triangle))
                nearest = hit;
        }
    }
    return nearest;
}

}  // namespace dpl
