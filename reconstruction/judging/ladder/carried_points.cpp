// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/ladder/carried_points.h"

#include "reconstruction/subject/shape/closest_surface.h"
#include "sdk/math/binding.h"

namespace dpl {
namespace {

constexpr float kFacing = 0.2f;  // cosine between the normals of a point and of a triangle that may carry it
constexpr size_t kPointGrain = 64;

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
    std::vector<Triangle> candidates;
    for (size_t t = 0; t < triangles.size(); ++t) {
        const Triangle& c = triangles[t];
        const Vec3f cross = glm::cross(surface[c.y] - surface[c.x], surface[c.z] - surface[c.x]);
        if (allowed[t] && glm::length(cross) > 0) candidates.push_back(c);  // a triangle without area has no frame
    }
    const ClosestSurface closest(surface, candidates);
    jobs.forRange(points.size(), kPointGrain, [&](size_t begin, size_t end, uint32_t) {
        for (size_t i = begin; i < end; ++i) {
            SurfacePoint at = closest.findFacing(points[i], normals[i], kFacing);
            if (!at.found()) at = closest.find(points[i]);
            Anchor& anchor = anchors_[i];
            anchor.corners = candidates[at.triangle], anchor.uv = {at.barycentric.y, at.barycentric.z};
            anchor.place =
                glm::transpose(frameOf(anchor.corners, surface)) * (Vec3d(points[i]) - pointOf(anchor.corners, anchor.uv, surface));
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

std::vector<Vec3f> CarriedPoints::places(std::span<const Vec3f> surface) const {
    std::vector<Vec3f> places;
    for (const Anchor& anchor : anchors_) places.push_back(Vec3f(pointOf(anchor.corners, anchor.uv, surface)));
    return places;
}

std::vector<float> CarriedPoints::distancesM() const {
    std::vector<float> out;
    for (const Anchor& anchor : anchors_) out.push_back(float(glm::length(anchor.place)));
    return out;
}

}  // namespace dpl
