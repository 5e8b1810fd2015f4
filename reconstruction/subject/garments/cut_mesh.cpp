// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/cut_mesh.h"

#include <cmath>
#include <map>

namespace dpl {
namespace {

constexpr float kSnap = 0.2f;  // share of an edge

}  // namespace

void cutAtZero(TaggedMesh& tagged, std::vector<float> value, uint8_t open, uint8_t positive) {
    SurfaceMesh& mesh = tagged.mesh;
    const std::vector<float> given = value;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (tagged.tags[t] != open) continue;
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
            if (given[a] * given[b] >= 0) continue;
            const float share = given[a] / (given[a] - given[b]);
            if (share < kSnap) value[a] = 0;
            if (share > 1 - kSnap) value[b] = 0;
        }
    }
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> cuts;  // edge → new vertex
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (tagged.tags[t] != open) continue;
        for (int k = 0; k < 3; ++k) {
            const auto [a, b] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
            if (value[a] * value[b] >= 0) continue;
            const auto [place, fresh] = cuts.try_emplace({a, b}, uint32_t(mesh.positions.size()));
            if (!fresh) continue;
            const float share = value[a] / (value[a] - value[b]);
            mesh.positions.push_back(mesh.positions[a] + share * (mesh.positions[b] - mesh.positions[a]));
            for (size_t c = 0; c < tagged.columns; ++c) {
                const float va = tagged.rows[a * tagged.columns + c], vb = tagged.rows[b * tagged.columns + c];
                tagged.rows.push_back(va + share * (vb - va));
            }
            value.push_back(0);
        }
    }
    const auto cutOn = [&](uint32_t a, uint32_t b) {
        const auto found = cuts.find(std::minmax(a, b));
        return found == cuts.end() ? UINT32_MAX : found->second;
    };
    std::vector<Triangle> triangles;
    std::vector<uint8_t> tags;
    const auto emit = [&](const Triangle& t, uint8_t tag, float side) {
        triangles.push_back(t);
        tags.push_back(tag == open && side > 0 ? positive : tag);
    };
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle t = mesh.triangles[i];
        const uint8_t tag = tagged.tags[i];
        uint32_t cut[3];
        int count = 0, first = 0;
        for (int k = 0; k < 3; ++k) {
            cut[k] = cutOn(t[k], t[(k + 1) % 3]);
            if (cut[k] != UINT32_MAX) ++count, first = k;
        }
        if (count == 0) {
            const float side = value[t.x] + value[t.y] + value[t.z];
            emit(t, tag, side != 0 ? side : given[t.x] + given[t.y] + given[t.z]);
        } else if (count == 1) {  // the cut edge runs from a to b
            const uint32_t a = t[first], b = t[(first + 1) % 3], c = t[(first + 2) % 3], m = cut[first];
            emit({a, m, c}, tag, value[a]);
            emit({m, b, c}, tag, value[b]);
        } else if (count == 2) {  // corner a lies between the two cut edges
            int k = 0;
            while (cut[(k + 1) % 3] != UINT32_MAX) ++k;
            const uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3], ab = cut[k], ca = cut[(k + 2) % 3];
            emit({a, ab, ca}, tag, value[a]);
            const Vec3f across1 = mesh.positions[ab] - mesh.positions[c], across2 = mesh.positions[b] - mesh.positions[ca];
            if (glm::dot(across1, across1) <= glm::dot(across2, across2)) {
                emit({ab, b, c}, tag, value[b]);
                emit({ab, c, ca}, tag, value[c]);
            } else {
                emit({ab, b, ca}, tag, value[b]);
                emit({b, c, ca}, tag, value[b]);
            }
        } else {  // only in a triangle with another tag, between three cut neighbours
            emit({cut[0], cut[1], cut[2]}, tag, 0);
            for (int k = 0; k < 3; ++k) emit({t[k], cut[k], cut[(k + 2) % 3]}, tag, 0);
        }
    }
    mesh.triangles = std::move(triangles);
    tagged.tags = std::move(tags);
}

}  // namespace dpl
