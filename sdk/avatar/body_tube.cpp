// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/body_tube.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr float kTau = 6.2831853f;
constexpr size_t kLeastTubeVertices = 12, kAround = 24, kAlong = 10;
constexpr int kStrong = 128;  // of 255: a vertex belongs to the joint that has half of its weight

}  // namespace

std::optional<size_t> ownerOf(const MeshData& mesh, size_t vertex) {
    for (int i = 0; i < 4; ++i)
        if (mesh.jointWeights[vertex][i] >= kStrong) return mesh.jointIndices[vertex][i];
    return std::nullopt;
}

std::optional<BodyTube> BodyTube::of(std::span<const JointData> joints, const MeshData& mesh, size_t first, size_t last, size_t joint,
                                     const Vec3f& to) {
    BodyTube tube;
    tube.joint = joint;
    tube.from = joints[joint].restPosition;
    if (!(glm::length(to - tube.from) > 0.01f)) return std::nullopt;
    tube.along = glm::normalize(to - tube.from);
    const Vec3f ahead(0, 0, 1), other(1, 0, 0);
    const Vec3f side = std::abs(tube.along.z) < 0.9f ? ahead : other;
    tube.across = glm::normalize(side - tube.along * glm::dot(side, tube.along));
    tube.third = glm::cross(tube.along, tube.across);
    std::vector<Vec3f> at;  // along, radius, angle
    for (size_t v = first; v < last; ++v) {
        if (ownerOf(mesh, v) != joint) continue;
        const Vec3f p = mesh.restPositions[v] - tube.from;
        const float x = glm::dot(p, tube.across), y = glm::dot(p, tube.third);
        at.push_back({glm::dot(p, tube.along), std::hypot(x, y), std::atan2(y, x)});
    }
    if (at.size() < kLeastTubeVertices) return std::nullopt;
    tube.beginM = tube.endM = at[0].x;
    for (const Vec3f& p : at) tube.beginM = std::min(tube.beginM, p.x), tube.endM = std::max(tube.endM, p.x);
    if (tube.endM - tube.beginM < 0.01f) return std::nullopt;
    tube.radiiM.assign(kAlong * kAround, 0.0f);
    for (const Vec3f& p : at) {
        const size_t k = std::min(size_t((p.x - tube.beginM) / (tube.endM - tube.beginM) * float(kAlong)), kAlong - 1);
        const size_t a = size_t((p.z / kTau + 1.5f) * float(kAround)) % kAround;
        float& radius = tube.radiiM[k * kAround + a];
        radius = std::max(radius, p.y);
    }
    // Cells without vertices take the mean of the nearest ones around, of the same ring.
    for (size_t k = 0; k < kAlong; ++k) {
        const std::vector<float> ring(tube.radiiM.begin() + std::ptrdiff_t(k * kAround),
                                      tube.radiiM.begin() + std::ptrdiff_t((k + 1) * kAround));
        for (size_t a = 0; a < kAround; ++a) {
            if (ring[a] > 0) continue;
            float sum = 0;
            for (const int way : {1, -1})
                for (size_t n = 1; n <= kAround / 4; ++n)
                    if (const float r = ring[size_t(int(a + kAround) + way * int(n)) % kAround]; r > 0) {
                        sum += 0.5f * r;
                        break;
                    }
            tube.radiiM[k * kAround + a] = sum;
        }
    }
    for (auto ring = tube.radiiM.begin(); ring != tube.radiiM.end(); ring += kAround)
        tube.widestM.push_back(*std::max_element(ring, ring + kAround));
    return tube;
}

float BodyTube::ringAt(float alongM) const {
    return std::clamp((alongM - beginM) / (endM - beginM) * float(kAlong) - 0.5f, 0.0f, float(kAlong - 1));
}

float BodyTube::radiusAt(float k, float angleRad) const {
    const float a = (angleRad / kTau + 1.5f) * float(kAround) - 0.5f;
    const size_t k0 = size_t(k), k1 = std::min(k0 + 1, kAlong - 1), a0 = size_t(a) % kAround, a1 = (a0 + 1) % kAround;
    const float u = k - float(k0), v = a - std::floor(a);
    const auto at = [&](size_t i, size_t j) { return radiiM[i * kAround + j]; };
    return (1 - u) * ((1 - v) * at(k0, a0) + v * at(k0, a1)) + u * ((1 - v) * at(k1, a0) + v * at(k1, a1));
}

std::optional<BodyTube::Place> BodyTube::placeOf(const Vec3f& local, float withinM) const {
    Place place;
    place.share = std::min({(local.x - beginM) / kTaperM + 1, (endM - local.x) / kTaperM + 1, 1.0f});
    if (!(place.share > 0)) return std::nullopt;
    const float ring = ringAt(local.x);
    place.distanceM = std::sqrt(local.y * local.y + local.z * local.z);
    const size_t k0 = size_t(ring), k1 = std::min(k0 + 1, kAlong - 1);
    if (place.distanceM < 1e-4f || place.distanceM > std::max(widestM[k0], widestM[k1]) + withinM) return std::nullopt;
    place.radiusM = radiusAt(ring, std::atan2(local.z, local.y));
    if (place.radiusM <= 0) return std::nullopt;
    return place;
}

}  // namespace dpl
