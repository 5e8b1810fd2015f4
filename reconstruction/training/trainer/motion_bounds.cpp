// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/motion_bounds.h"

#include <algorithm>
#include <set>

#include "reconstruction/training/correctives/motion_model.h"
#include "reconstruction/training/trainer/priors.h"

namespace dpl {

MotionBounds::MotionBounds(std::span<const JointData> joints, const MeshData& mesh, const PoseCorrectiveData& c)
    : heard_(motionReachingNodes(joints, mesh, c)) {
    std::vector<Vec4d> places(c.nodeCount, Vec4d(0));  // weighted sum of the vertices that a node moves; weight
    std::set<std::pair<uint32_t, uint32_t>> pairs;
    for (size_t v = 0; v < mesh.restPositions.size(); ++v)
        for (int i = 0; i < 4; ++i) {
            const uint32_t n = c.nodeIndices[v][i];
            if (c.nodeWeights[v][i] == 0 || heard_[n] == 0) continue;
            places[n] += double(c.nodeWeights[v][i]) * Vec4d(Vec3d(mesh.restPositions[v]), 1);
            for (int k = 0; k < i; ++k)
                if (const uint32_t other = c.nodeIndices[v][k]; c.nodeWeights[v][k] != 0 && heard_[other] != 0 && other != n)
                    pairs.emplace(std::min(n, other), std::max(n, other));
        }
    for (const auto& [a, b] : pairs)
        neighbours_.push_back({a, b, float(glm::length(Vec3d(places[a]) / places[a].w - Vec3d(places[b]) / places[b].w))});
}

void MotionBounds::apply(PoseCorrectiveData& c) const {
    const size_t columns = c.columnCount();
    size_t first = c.modeCount;
    for (size_t g = 0; g < c.motion.groups.size(); first += c.motion.groups[g++].columnCount) {
        const float strain = g == 0 ? priors::kMovedStrain : isOfPeaks(c.motion, g) ? priors::kPeakStrain : priors::kComponentStrain;
        for (size_t i = first; i < first + c.motion.groups[g].columnCount; ++i) {
            for (size_t n = 0; n < heard_.size(); ++n)
                if (Vec4f& value = c.nodes[n * columns + i]; !(heard_[n] >> g & 1)) value = Vec4f(0, 0, 0, value.w);
            for (const auto& [a, b, distance] : neighbours_) {
                Vec4f &one = c.nodes[a * columns + i], &other = c.nodes[b * columns + i];
                const Vec3f apart = Vec3f(other) - Vec3f(one);
                const float most = strain * distance, length = glm::length(apart);
                if (!(length > most)) continue;
                const Vec4f half(0.5f * (1 - most / length) * apart, 0);
                one += half, other -= half;
            }
        }
    }
}

}  // namespace dpl
