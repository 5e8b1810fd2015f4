// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/surface/triangle_labels.h"

#include <algorithm>
#include <array>
#include <map>

#include "reconstruction/input/capture/frame_picture.h"

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
        if (id == kNoTriangle || !isPerson(mask[pixel]) || labels[pixel] == 0) continue;
        const double cosine = frontCosine(positions, triangles[id], eye);
        if (!(cosine > 0.1)) continue;
        std::vector<float>& votes = votes_[labels[pixel]];
        votes.resize(triangleCount_, 0.0f);
        votes[id] += float(cosine);
    }
}

std::vector<uint8_t> TriangleLabels::finish(std::span<const Triangle> triangles, uint8_t fallback) const {
    const auto neighbours = edgeNeighbours(triangles);
    std::vector<uint8_t> label(triangleCount_, 0);  // 0: not known yet
    std::vector<float> most(triangleCount_, 0.0f);
    for (size_t value = 1; value < votes_.size(); ++value) {
        std::vector<float> votes = votes_[value];
        if (votes.empty()) continue;
        for (int round = 0; round < 2; ++round) {
            std::vector<float> shared = votes;
            for (size_t t = 0; t < triangleCount_; ++t)
                for (const uint32_t n : neighbours[t])
                    if (n != kNoTriangle) shared[t] += 0.5f * votes[n];
            votes = std::move(shared);
        }
        for (size_t t = 0; t < triangleCount_; ++t)
            if (votes[t] > most[t]) most[t] = votes[t], label[t] = uint8_t(value);
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
