// SPDX-License-Identifier: Apache-2.0
// Balls that two joints move.
#pragma once

#include <algorithm>
#include <cmath>

#include "sdk/format/avatar_data.h"

namespace dpl::test {

inline MeshData ballMesh(uint32_t rings = 10, uint32_t sides = 14, float radius = 0.2f) {
    MeshData m;
    for (uint32_t r = 0; r <= rings; ++r)
        for (uint32_t s = 0; s < sides; ++s) {
            if ((r == 0 || r == rings) && s > 0) continue;
            const float theta = 3.14159265f * float(r) / float(rings), phi = 6.2831853f * float(s) / float(sides);
            m.restPositions.push_back(radius * Vec3f(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi)));
        }
    const auto at = [&](uint32_t r, uint32_t s) -> uint32_t {
        return r == 0 ? 0 : r == rings ? uint32_t(m.restPositions.size()) - 1 : 1 + (r - 1) * sides + s % sides;
    };
    for (uint32_t r = 0; r < rings; ++r)
        for (uint32_t s = 0; s < sides; ++s) {
            if (r > 0) m.triangles.push_back({at(r, s), at(r + 1, s), at(r, s + 1)});
            if (r + 1 < rings) m.triangles.push_back({at(r, s + 1), at(r + 1, s), at(r + 1, s + 1)});
        }
    for (const Vec3f& p : m.restPositions) {
        const uint8_t upper = uint8_t(std::lround(255 * std::clamp(0.5f + 2 * p.y, 0.0f, 1.0f)));
        m.jointIndices.push_back({0, 1, 0, 0});
        m.jointWeights.push_back({uint8_t(255 - upper), upper, 0, 0});
    }
    return m;
}

/** A body of 0.2 m within a garment of radius garmentM, which ends `open` triangles before the south pole, where the body shows. */
inline MeshData dressedBall(size_t open, float garmentM = 0.25f) {
    MeshData mesh = ballMesh(20, 28, 0.2f);
    const MeshData outer = ballMesh(20, 28, garmentM);
    const uint32_t vertices = uint32_t(mesh.restPositions.size()), triangles = uint32_t(mesh.triangles.size());
    mesh.layers = {{"body", "body", 0, vertices, 0, triangles},
                   {"top", "garment", vertices, uint32_t(outer.restPositions.size()), triangles, triangles - uint32_t(open)}};
    mesh.restPositions.insert(mesh.restPositions.end(), outer.restPositions.begin(), outer.restPositions.end());
    mesh.jointIndices.insert(mesh.jointIndices.end(), outer.jointIndices.begin(), outer.jointIndices.end());
    mesh.jointWeights.insert(mesh.jointWeights.end(), outer.jointWeights.begin(), outer.jointWeights.end());
    for (size_t t = 0; t + open < outer.triangles.size(); ++t) mesh.triangles.push_back(outer.triangles[t] + Triangle(vertices));
    return mesh;
}

}  // namespace dpl::test
