// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/ladder/carried_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sdk/math/binding.h"

namespace dpl {
namespace {

constexpr double kFacing = 0.2;  // cosine between the normals of a point and of a triangle that may carry it
constexpr size_t kPointGrain = 64;

/** Barycentric (corners 1 and 2) of the point of triangle abc nearest to p. */
Vec2d nearestOnTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d ab = b - a, ac = c - a, ap = p - a;
    const double aa = glm::dot(ab, ab), bb = glm::dot(ab, ac), cc = glm::dot(ac, ac), x = glm::dot(ab, ap), y = glm::dot(ac, ap);
    const double det = aa * cc - bb * bb;
    if (det > 1e-20) {
        const double u = (cc * x - bb * y) / det, v = (aa * y - bb * x) / det;
        if (u >= 0 && v >= 0 && u + v <= 1) return {u, v};
    }
    // Outside: the nearest point lies on an edge.
    const auto along = [](double numerator, double denominator) {
        return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0.0;
    };
    const double s = along(x, aa), t = along(y, cc), w = along(glm::dot(p - b, c - b), glm::dot(c - b, c - b));
    const Vec2d edges[3] = {{s, 0}, {0, t}, {1 - w, w}};
    Vec2d best = edges[0];
    double least = std::numeric_limits<double>::infinity();
    for (const Vec2d& uv : edges) {
        const Vec3d away = p - (a + uv.x * ab + uv.y * ac);
        if (const double d = glm::dot(away, away); d < least) least = d, best = uv;
    }
    return best;
}

Vec3d pointOf(const Triangle& t, const Vec2d& uv, std::span<const Vec3f> surface) {
    const Vec3d a(surface[t.x]), b(surface[t.y]), c(surface[t.z]);
    return a + uv.x * (b - a) + uv.y * (c - a);
}

Mat3d frameOf(const Triangle& t, std::span<const Vec3f> surface) {
    return restTriangle(Vec3d(surface[t.x]), Vec3d(surface[t.y]), Vec3d(surface[t.z])).frame;
}

}  // namespace

CarriedPoints::CarriedPoints(std::span<const Vec3f> points, std::span<const Vec3f> normals, std::span<const Vec3f> surface,
                             std::span<const Triangle> triangles, std::span<const uint8_t> allowed, Jobs& jobs)
    : anchors_(points.size()) {
    struct Candidate {
        Vec3d centre, normal;
        double radius;
        uint32_t triangle;
    };
    std::vector<Candidate> candidates;
    for (size_t t = 0; t < triangles.size(); ++t) {
        if (!allowed[t]) continue;
        const Vec3d a(surface[triangles[t].x]), b(surface[triangles[t].y]), c(surface[triangles[t].z]), centre = (a + b + c) / 3.0;
        const Vec3d cross = glm::cross(b - a, c - a);
        const double length = glm::length(cross);
        if (!(length > 0)) continue;
        candidates.push_back(
            {centre, cross / length, std::max({glm::length(a - centre), glm::length(b - centre), glm::length(c - centre)}), uint32_t(t)});
    }
    jobs.forRange(points.size(), kPointGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t i = begin; i < end; ++i) {
            const Vec3d p(points[i]), n(normals[i]);
            for (const bool facing : {true, false}) {
                double best = std::numeric_limits<double>::infinity();
                for (const Candidate& candidate : candidates) {
                    const Vec3d d = p - candidate.centre;
                    const double reach = best + candidate.radius;
                    if (glm::dot(d, d) >= reach * reach || (facing && glm::dot(n, candidate.normal) < kFacing)) continue;
                    const Triangle& t = triangles[candidate.triangle];
                    const Vec2d uv = nearestOnTriangle(p, Vec3d(surface[t.x]), Vec3d(surface[t.y]), Vec3d(surface[t.z]));
                    const double distance = glm::length(p - pointOf(t, uv, surface));
                    if (distance < best) best = distance, anchors_[i].corners = t, anchors_[i].uv = uv;
                }
                if (std::isfinite(best)) break;
            }
            Anchor& anchor = anchors_[i];
            anchor.place = glm::transpose(frameOf(anchor.corners, surface)) * (p - pointOf(anchor.corners, anchor.uv, surface));
        }
    });
}

void CarriedPoints::average(std::span<const Vec3f> points, std::span<const Vec3f> surface) {
    ++averaged_;
    for (size_t i = 0; i < anchors_.size(); ++i) {
        Anchor& anchor = anchors_[i];
        const Vec3d place =
            glm::transpose(frameOf(anchor.corners, surface)) * (Vec3d(points[i]) - pointOf(anchor.corners, anchor.uv, surface));
        anchor.place = averaged_ == 1 ? place : anchor.place + (place - anchor.place) / double(averaged_);
    }
}

std::vector<Vec3f> CarriedPoints::at(std::span<const Vec3f> surface) const {
    std::vector<Vec3f> points(anchors_.size());
    for (size_t i = 0; i < points.size(); ++i) {
        const Anchor& anchor = anchors_[i];
        points[i] = Vec3f(pointOf(anchor.corners, anchor.uv, surface) + frameOf(anchor.corners, surface) * anchor.place);
    }
    return points;
}

std::vector<float> CarriedPoints::distancesM() const {
    std::vector<float> out;
    for (const Anchor& anchor : anchors_) out.push_back(float(glm::length(anchor.place)));
    return out;
}

std::vector<Vec3f> vertexNormals(std::span<const Vec3f> positions, std::span<const Triangle> triangles) {
    std::vector<Vec3f> normals(positions.size(), Vec3f(0));
    for (const Triangle& t : triangles) {
        const Vec3f cross = glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
        for (int c = 0; c < 3; ++c) normals[t[c]] += cross;
    }
    for (Vec3f& n : normals) {
        const float length = glm::length(n);
        n = length > 0 ? n / length : Vec3f(0, 1, 0);
    }
    return normals;
}

}  // namespace dpl
