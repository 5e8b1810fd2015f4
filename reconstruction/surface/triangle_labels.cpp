// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/surface/triangle_labels.h"

#include <algorithm>
#include <array>
#include <map>

#include "reconstruction/capture/frame_picture.h"

namespace dpl {
namespace {

/** The neighbours of each triangle across its three edges. On an edge with more than two triangles only the first two are neighbours. */
std::vector<std::array<uint32_t, 3>> edgeNeighbours(std::span<const Triangle> triangles) {
    std::map<std::pair<uint32_t, uint32_t>, std::pair<uint32_t, int>> open;
    std::vector<std::array<uint32_t, 3>> neighbours(triangles.size(), {kNoTriangle, kNoTriangle, kNoTriangle});
    for (uint32_t t = 0; t < triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
            const auto key = std::minmax(a, b);
            const auto found = open.find(key);
            if (found == open.end()) {
                open.emplace(key, std::pair(t, k));
            } else {
                neighbours[t][size_t(k)] = found->second.first;
                neighbours[found->second.first][size_t(found->second.second)] = t;
                open.erase(found);
            }
        }
    return neighbours;
}

}  // namespace

void TriangleLabels::add(const MeshRaster& raster, std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                         const Camerad& camera, std::span<const uint8_t> labels, std::span<const uint8_t> mask) {
    const Vec3d eye = camera.eye();
    for (size_t pixel = 0; pixel < raster.triangle.size(); ++pixel) {
        const uint32_t id = raster.triangle[pixel];
        if (id == kNoTriangle || !isPerson(mask[pixel]) || labels[pixel] == 0 || labels[pixel] >= kLabels) continue;
        const Vec3d a(positions[triangles[id].x]), b(positions[triangles[id].y]), c(positions[triangles[id].z]);
        const Vec3d normal = glm::cross(b - a, c - a), toEye = eye - a;
        const double cosine = glm::dot(normal, toEye) / std::max(1e-20, glm::length(normal) * glm::length(toEye));
        if (cosine > 0.1) votes_[id].byLabel[labels[pixel]] += float(cosine);
    }
}

std::vector<uint8_t> TriangleLabels::finish(std::span<const Triangle> triangles, uint8_t fallback) const {
    const auto neighbours = edgeNeighbours(triangles);
    std::vector<Votes> votes = votes_;
    for (int round = 0; round < 2; ++round) {
        std::vector<Votes> shared = votes;
        for (size_t t = 0; t < votes.size(); ++t)
            for (uint32_t n : neighbours[t])
                for (size_t k = 0; n != kNoTriangle && k < kLabels; ++k) shared[t].byLabel[k] += 0.5f * votes[n].byLabel[k];
        votes = std::move(shared);
    }
    std::vector<uint8_t> label(votes.size(), 0);  // 0: not known yet
    for (size_t t = 0; t < votes.size(); ++t) {
        const auto best = std::max_element(std::begin(votes[t].byLabel), std::end(votes[t].byLabel));
        if (*best > 0) label[t] = uint8_t(best - std::begin(votes[t].byLabel));
    }
    for (bool grew = true; grew;) {
        grew = false;
        std::vector<uint8_t> next = label;
        for (size_t t = 0; t < label.size(); ++t) {
            if (label[t] != 0) continue;
            for (uint32_t n : neighbours[t])
                if (n != kNoTriangle && label[n] != 0) {
                    next[t] = label[n], grew = true;
                    break;
                }
        }
        label = std::move(next);
    }
    for (uint8_t& l : label)
        if (l == 0) l = fallback;
    return label;
}

}  // namespace dpl
