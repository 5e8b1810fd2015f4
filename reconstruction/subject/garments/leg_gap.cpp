// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/leg_gap.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "reconstruction/subject/garments/body_parts.h"

namespace dpl {
namespace {

constexpr float kHalfM = 0.007f;        // of the slab: the cells of the hull are 8 mm wide
constexpr float kBelowCrotchM = 0.02f;  // trousers hang below the crotch
constexpr float kBetweenM = 0.03f;      // from the middle, within which cloth lies between the legs
constexpr float kClosedM = 0.001f;      // of each wall, from the middle
constexpr float kTaperM = 0.02f;        // below its top the slab closes less, or the ends of the walls would fold
constexpr float kFadeM = 2 * kHalfM;    // beyond its faces the mesh moves less and less
constexpr uint8_t kLeft = 1, kRight = 2;

/** Which leg moves more of a vertex: positive is the left one. */
int sideOf(const MeshData& body, std::span<const uint8_t> ofJoint, uint32_t v) {
    int side = 0;
    for (int k = 0; k < 4; ++k) {
        if (body.jointWeights[v][k] == 0) continue;  // then the joint may be out of range
        const uint8_t part = ofJoint[body.jointIndices[v][k]];
        side += int(body.jointWeights[v][k]) * (part == kLeft ? 1 : part == kRight ? -1 : 0);
    }
    return side;
}

Vec3f middleOf(std::span<const Vec3f> posed, const std::vector<Triangle>& triangles) {
    Vec3f sum(0);
    for (const Triangle& t : triangles) sum += (posed[t.x] + posed[t.y] + posed[t.z]) / 3.0f;
    return sum / float(triangles.size());
}

}  // namespace

LegGap::LegGap(const MeshData& body, std::span<const JointData> joints, std::span<const Vec3f> posed) {
    const std::vector<uint8_t> ofJoint = partsOfJoints(joints, {{"leftUpperLeg", kLeft}, {"rightUpperLeg", kRight}});
    const std::vector<uint8_t> parts = partsOfTriangles(body, ofJoint);
    std::vector<Triangle> left, right;
    float crotch = std::numeric_limits<float>::infinity();
    for (size_t t = 0; t < parts.size(); ++t) {
        const Triangle& corners = body.triangles[t];
        if (parts[t] == kLeft) left.push_back(corners);
        if (parts[t] == kRight) right.push_back(corners);
        const auto [least, most] =
            std::minmax({sideOf(body, ofJoint, corners.x), sideOf(body, ofJoint, corners.y), sideOf(body, ofJoint, corners.z)});
        if (least <= 0 && most >= 0 && least < most)
            crotch = std::min({crotch, posed[corners.x].y, posed[corners.y].y, posed[corners.z].y});
    }
    if (left.empty() || right.empty() || !std::isfinite(crotch)) return;
    const Vec3f l = middleOf(posed, left), r = middleOf(posed, right);
    const Vec3f across(l.x - r.x, 0, l.z - r.z);
    if (!(glm::length(across) > 4 * kHalfM)) return;
    topM_ = crotch - kBelowCrotchM;
    between_ = 0.5f * (l + r), across_ = glm::normalize(across), reachM_ = 0.5f * glm::length(across);
    left_.emplace(posed, left), right_.emplace(posed, right);
}

bool LegGap::near(const Vec3f& point) const {
    return point.y < topM_ && std::abs(glm::dot(point - between_, across_)) < reachM_;
}

LegGap::Halfway LegGap::halfway(const Vec3f& point) const {
    const SurfacePoint l = left_->find(point), r = right_->find(point);
    const Vec3f away = (point - l.position) / std::max(1e-6f, l.distanceM) - (point - r.position) / std::max(1e-6f, r.distanceM);
    const float length = glm::length(away);
    return {0.5f * (l.distanceM - r.distanceM), length > 1e-6f ? away / length : -across_};
}

float LegGap::operator()(const Vec3f& point) const {
    if (empty() || !near(point)) return -1;
    return std::min(kHalfM - std::abs(halfway(point).sideM), topM_ - point.y);
}

std::vector<uint8_t> LegGap::between(std::span<const Vec3f> positions, std::span<const Triangle> triangles) const {
    std::vector<uint8_t> at;
    for (const Vec3f& p : positions) at.push_back(!empty() && near(p) && std::abs(halfway(p).sideM) < kBetweenM);
    std::vector<uint8_t> flags;
    for (const Triangle& t : triangles) flags.push_back(at[t.x] && at[t.y] && at[t.z]);
    return flags;
}

void LegGap::close(SurfaceMesh& mesh, const std::function<bool(const Vec3f&)>& where) const {
    for (Vec3f& p : mesh.positions) {
        if (empty() || !near(p) || !where(p)) continue;
        const Halfway at = halfway(p);
        const float side = std::abs(at.sideM);
        const float fade = std::clamp(1 - (side - kHalfM) / kFadeM, 0.0f, 1.0f) * std::clamp((topM_ - p.y) / kTaperM, 0.0f, 1.0f);
        const float way = fade * std::max(0.0f, std::min(side, kHalfM) - kClosedM);
        p += std::copysign(way, -at.sideM) * at.toRight;
    }
}

}  // namespace dpl
