// SPDX-License-Identifier: Apache-2.0
#include "sdk/surface/layer_cover.h"

#include <algorithm>

#include "sdk/surface/ray_caster.h"

namespace dpl {

LayerCover coverBelow(const MeshData& mesh, size_t layer, std::span<const uint8_t> carries, std::span<const uint8_t> leftOut) {
    const LayerData& own = mesh.layers[layer];
    std::vector<uint8_t> without(leftOut.begin(), leftOut.end());
    without.resize(mesh.triangles.size(), 0);
    std::fill_n(without.begin() + std::ptrdiff_t(own.firstTriangle), own.triangleCount, uint8_t(1));
    std::vector<uint8_t> dressed(mesh.restPositions.size(), 0);  // vertices of triangles that carry splats
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3 && carries[t]; ++k) dressed[mesh.triangles[t][k]] = 1;
    const auto normalOf = [&](const Triangle& t) {
        const Vec3d a(mesh.restPositions[t.x]), b(mesh.restPositions[t.y]), c(mesh.restPositions[t.z]);
        return glm::cross(b - a, c - a);
    };
    RayCaster caster(mesh);
    caster.follow(mesh.restPositions);
    constexpr double kOutsideM = 0.005;  // what lies below may come through the layer by that
    LayerCover cover;
    for (size_t t = own.firstTriangle; t < own.firstTriangle + own.triangleCount; ++t) {
        const Triangle& corners = mesh.triangles[t];
        const Vec3d normal = normalOf(corners);
        const double twiceArea = glm::length(normal);
        if (!carries[t] || !(twiceArea > 0)) continue;
        const Vec3d centre =
            (Vec3d(mesh.restPositions[corners.x]) + Vec3d(mesh.restPositions[corners.y]) + Vec3d(mesh.restPositions[corners.z])) / 3.0;
        const SurfaceRay ray{centre + kOutsideM * normal / twiceArea, -normal / twiceArea};
        const auto hit = caster.cast(mesh.restPositions, ray, without);
        if (!hit || hit->distanceM > kBelowM) continue;
        const Triangle& below = mesh.triangles[hit->triangle];
        if (glm::dot(normalOf(below), ray.direction) >= 0) continue;  // its inside: another layer lies over this one
        cover.shownM2 += twiceArea / 2;
        if (!dressed[below.x] && !dressed[below.y] && !dressed[below.z]) cover.bareM2 += twiceArea / 2;
    }
    return cover;
}

}  // namespace dpl
