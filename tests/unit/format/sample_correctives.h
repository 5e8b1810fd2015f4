// SPDX-License-Identifier: Apache-2.0
// Random but reproducible pose correctives for any avatar with joints and vertices.
#pragma once

#include <algorithm>
#include <random>

#include "sdk/format/avatar_data.h"
#include "sdk/format/skin_weights.h"

namespace dpl::test {

struct CorrectiveOptions {
    uint32_t modes = 3, nodes = 12;
    float offsetM = 0.02f, light = 0.4f;  // standard deviation of a node's values, for ‖k‖ = 1
    float reach = 1.5f, reachOffModes = 1e6f;
};

/** All joints are in the feature. Nodes lie at vertices; a vertex uses the four nearest. A rotated joint gives coefficients of about 1. */
inline PoseCorrectiveData randomCorrectives(const AvatarData& avatar, uint32_t seed, const CorrectiveOptions& o = {}) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    PoseCorrectiveData c;
    c.modeCount = o.modes, c.nodeCount = o.nodes, c.reach = o.reach, c.reachOffModes = o.reachOffModes;
    for (uint32_t j = 0; j < avatar.joints.size(); ++j) c.joints.push_back(j);
    const size_t features = 6 * c.joints.size();
    for (size_t f = 0; f < features; ++f) c.mean.push_back(0.1f * normal(random));
    for (size_t f = 0; f < features * o.modes; ++f) c.modes.push_back(2 * normal(random) / std::sqrt(float(features)));
    std::vector<Vec3f> places;
    for (uint32_t n = 0; n < o.nodes; ++n) places.push_back(avatar.mesh.restPositions[random() % avatar.mesh.restPositions.size()]);
    for (const Vec3f& p : avatar.mesh.restPositions) {
        std::vector<std::pair<uint32_t, float>> near;
        for (uint32_t n = 0; n < o.nodes; ++n) near.emplace_back(n, 1 / (0.02f + glm::length(p - places[n])));
        const PackedWeights packed = packWeights(near);
        c.nodeIndices.push_back(packed.joints), c.nodeWeights.push_back(packed.weights);
    }
    const float scale = 1 / std::sqrt(float(o.modes));
    for (size_t e = 0; e < size_t(o.nodes) * o.modes; ++e) {
        const Vec3f offset(normal(random), normal(random), normal(random));
        c.nodes.emplace_back(scale * o.offsetM * offset, scale * o.light * normal(random));
    }
    return c;
}

inline AvatarData withCorrectives(AvatarData avatar, uint32_t seed, const CorrectiveOptions& options = {}) {
    avatar.correctives = randomCorrectives(avatar, seed, options);
    return avatar;
}

}  // namespace dpl::test
