// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/cloth_strain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace dpl {
namespace {

constexpr float kShortestEdgeM = 1e-4f;
constexpr float kNoLimit = 0.99f;  // nothing strains a hundred times as far
constexpr int kSweeps = 2;         // over all pairs: what a node does must not jump when a pair comes to its limit

/** By how much two nodes of the correctives may differ, metres. Key: the smaller one · 2¹⁶ + the other. */
using Limits = std::unordered_map<uint32_t, float>;

/** Weights of a node at the two ends of an edge, one less the other; 255 is 1. */
struct NodeChange {
    uint16_t node;
    int weight;
};

/** The limits that an edge sets: from one end to the other, weights go over from some nodes to others. Its strain is at most the share that
 *  goes over times the largest difference of two of these, over its length. */
void addLimits(const MeshData& mesh, const PoseCorrectiveData& c, uint32_t from, uint32_t to, Limits& limits) {
    const float lengthM = glm::length(mesh.restPositions[from] - mesh.restPositions[to]);
    if (!(lengthM >= kShortestEdgeM)) return;
    std::array<NodeChange, 8> changes;
    size_t count = 0;
    int share = 0;
    for (const auto& [vertex, sign] : {std::pair{from, -1}, {to, 1}})
        for (int k = 0; k < 4; ++k) {
            const uint16_t node = c.nodeIndices[vertex][k];
            const auto known = std::find_if(changes.begin(), changes.begin() + count, [&](const NodeChange& n) { return n.node == node; });
            if (known == changes.begin() + count) changes[count++] = {node, 0};
            known->weight += sign * c.nodeWeights[vertex][k];
        }
    for (size_t i = 0; i < count; ++i) share += std::max(0, changes[i].weight);
    const float mostApartM = kMostStrain * lengthM * 255 / float(share);
    for (size_t i = 0; i < count; ++i)
        for (size_t j = 0; j < count; ++j)
            if (changes[i].weight > 0 && changes[j].weight < 0) {
                const auto [a, b] = std::minmax(changes[i].node, changes[j].node);
                float& most = limits.try_emplace(uint32_t(a) << 16 | b, mostApartM).first->second;
                most = std::min(most, mostApartM);
            }
}

/** Whether two nodes have learned other offsets. */
bool differ(const PoseCorrectiveData& c, uint16_t a, uint16_t b) {
    const size_t columns = c.columnCount();
    for (size_t i = 0; i < columns; ++i)
        if (Vec3f(c.nodes[a * columns + i]) != Vec3f(c.nodes[b * columns + i])) return true;
    return false;
}

}  // namespace

ClothStrain::ClothStrain(const MeshData& mesh, const PoseCorrectiveData& c) {
    if (c.empty() || c.columnCount() == 0) return;
    Limits limits;
    for (const LayerData& layer : mesh.layers) {
        if (layer.role != "garment") continue;
        for (uint32_t t = layer.firstTriangle; t < layer.firstTriangle + layer.triangleCount; ++t)
            for (int k = 0; k < 3; ++k) addLimits(mesh, c, mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3], limits);
    }
    std::vector<uint32_t> keys;  // of nodes that may come apart
    for (const auto& [key, most] : limits)
        if (differ(c, uint16_t(key >> 16), uint16_t(key))) keys.push_back(key);
    std::sort(keys.begin(), keys.end());
    for (const uint32_t key : keys) nodes_.push_back(uint16_t(key >> 16)), nodes_.push_back(uint16_t(key));
    std::sort(nodes_.begin(), nodes_.end());
    nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
    const auto at = [&](uint32_t node) { return uint16_t(std::lower_bound(nodes_.begin(), nodes_.end(), node) - nodes_.begin()); };
    for (const uint32_t key : keys) pairs_.push_back({at(key >> 16), at(key & 0xffff), limits[key]});
}

float ClothStrain::ease(std::span<Vec4f> nodes, float drawn, std::vector<Vec3f>& eased) const {
    const float filmed = drawn / kFilmedShare;
    if (pairs_.empty() || !(filmed < kNoLimit)) return 0;
    const float wider = 1 / (1 - filmed);
    eased.resize(nodes_.size());
    for (size_t n = 0; n < nodes_.size(); ++n) eased[n] = Vec3f(nodes[nodes_[n]]);
    for (int sweep = 0; sweep < kSweeps; ++sweep)
        for (const Pair& pair : pairs_) {
            const Vec3f apart = eased[pair.a] - eased[pair.b];
            const float length2 = glm::dot(apart, apart), mostApartM = wider * pair.mostApartM;
            if (!(length2 > mostApartM * mostApartM)) continue;
            const Vec3f step = 0.5f * (1 - mostApartM / std::sqrt(length2)) * apart;
            eased[pair.a] -= step, eased[pair.b] += step;
        }
    float most2 = 0;
    for (size_t n = 0; n < nodes_.size(); ++n) {
        Vec4f& node = nodes[nodes_[n]];
        const Vec3f by = eased[n] - Vec3f(node);
        most2 = std::max(most2, glm::dot(by, by));
        node = Vec4f(eased[n], node.w);
    }
    return std::sqrt(most2);
}

}  // namespace dpl
