// SPDX-License-Identifier: Apache-2.0
// A flat person in layers, all facing +Z, 1 m wide and high around (0, 1, 0): a body whose right half (x > 0) carries no splats, a top over
// its left half, a skirt over its right half, a scarf beside it, and a coat over all.
#pragma once

#include "tests/package/tiny_avatar.h"

namespace dpl::test {

enum DressedLayer : uint32_t { kBody, kTop, kSkirt, kScarf, kCoat };

/** Adds a layer of 4 × 4 squares. bareFrom: splats only on squares left of that x. */
inline void addSheet(AvatarData& a, const char* name, const char* role, float x0, float x1, float z, const Vec3f& colour, float bareFrom) {
    constexpr uint32_t n = 4, perTriangle = 40;
    LayerData layer{name, role, uint32_t(a.mesh.restPositions.size()), (n + 1) * (n + 1), uint32_t(a.mesh.triangles.size()), 2 * n * n};
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i) {
            a.mesh.restPositions.push_back({x0 + (x1 - x0) * float(i) / n, 0.5f + float(j) / n, z});
            a.mesh.colours.push_back(glm::u8vec4(255));
            a.mesh.jointIndices.push_back(glm::u16vec4(j >= 3 ? 1 : 0, j >= 3 ? 0 : 1, 0, 0));
            a.mesh.jointWeights.push_back(glm::u8vec4(200, 55, 0, 0));
        }
    const bool cloth = std::string_view(role) != "body";
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i)
            for (int half = 0; half < 2; ++half) {
                const uint32_t v = layer.firstVertex + j * (n + 1) + i;
                a.mesh.triangles.push_back(half == 0 ? Triangle{v, v + 1, v + n + 2} : Triangle{v, v + n + 2, v + n + 1});
                for (uint32_t s = 0; s < perTriangle && a.mesh.restPositions[v].x < bareFrom - 1e-4f; ++s) {
                    float u = (float(s % 8) + 0.5f) / 8, w = (float(s / 8) + 0.5f) / 5;
                    if (u + w > 1) u = 1 - u, w = 1 - w;
                    a.splats.uv.push_back({u, w});
                    a.splats.phi.push_back(0);
                    a.splats.scaleM.push_back({0.04f, 0.04f});
                    a.splats.opacity.push_back(0.97f);
                    a.splats.flags.push_back(cloth ? kSplatSingleFace | kSplatCloth : kSplatSingleFace);
                    for (int c = 0; c < 3; ++c) a.splats.sh.push_back((colour[c] - 0.5f) / 0.28209479177387814f);
                }
                a.splats.triangleStart.push_back(uint32_t(a.splats.uv.size()));
            }
    a.mesh.layers.push_back(layer);
}

inline AvatarData dressed() {
    AvatarData a = tinyAvatar();
    a.name = "dressed";
    a.mesh = {};
    a.splats = {};
    a.splats.triangleStart = {0};
    addSheet(a, "body", "body", -0.5f, 0.5f, 0, {1, 0, 0}, 0);
    addSheet(a, "top", "garment", -0.5f, 0, 0.02f, {0, 1, 0}, 9);
    addSheet(a, "skirt", "garment", 0, 0.5f, 0.02f, {0, 0, 1}, 9);
    addSheet(a, "scarf", "garment", 0.7f, 0.9f, 0.02f, {1, 1, 0}, 9);
    addSheet(a, "coat", "garment", -0.5f, 0.5f, 0.06f, {1, 1, 1}, 9);
    return a;
}

}  // namespace dpl::test
