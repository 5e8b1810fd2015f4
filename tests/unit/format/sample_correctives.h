// SPDX-License-Identifier: Apache-2.0
// Random but reproducible pose correctives for any avatar with joints and vertices.
#pragma once

#include <algorithm>
#include <random>

#include "sdk/format/avatar_data.h"
#include "sdk/format/motion_modes.h"
#include "sdk/format/skin_weights.h"

namespace dpl::test {

struct CorrectiveOptions {
    uint32_t modes = 3, nodes = 12;
    float offsetM = 0.02f, light = 0.4f;  // standard deviation of a node's values, for ‖k‖ = 1
    float reach = 1.5f, reachOffModes = 1e6f;
    uint32_t motion = 0;  // columns of motion modes
};

/** Motion modes of up to kMaxMotionJoints joints, two holds and a lag, in two groups. Random poses have moved, partly moved and rest, and
 * lie within reach and beyond it. */
inline MotionModeData randomMotion(size_t jointCount, uint32_t columns, std::mt19937& random) {
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> uniform;
    MotionModeData m;
    m.movedFromRad = 0.3f, m.movedToRad = 2.5f, m.holdsS = {0, 1.5f}, m.lagsS = {0.4f};
    for (uint32_t j = 0; j < std::min<size_t>(jointCount, kMaxMotionJoints); ++j) {
        m.joints.push_back(j);
        m.still.push_back(glm::normalize(Vec4f(0.2f * normal(random), 0.2f * normal(random), 0.2f * normal(random), 1)));
        m.rangeRad.emplace_back(0.2f * uniform(random), 0.2f + 2 * uniform(random));
    }
    if (columns > 1) m.groups.push_back({columns / 2, 0.8f});
    m.groups.push_back({columns - columns / 2, 1.2f});
    const size_t features = m.featureCount();
    for (size_t i = 0; i < features * columns; ++i) m.modes.push_back(normal(random) / std::sqrt(float(features)));
    return m;
}

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
    if (o.motion == 0) return c;
    addMotionModes(c, randomMotion(avatar.joints.size(), o.motion, random));
    for (size_t e = 0; e < c.nodes.size(); ++e)
        if (e % c.columnCount() >= c.modeCount)
            for (int a = 0; a < 4; ++a) c.nodes[e][a] = scale * (a == 3 ? o.light : o.offsetM) * normal(random);
    return c;
}

inline AvatarData withCorrectives(AvatarData avatar, uint32_t seed, const CorrectiveOptions& options = {}) {
    avatar.correctives = randomCorrectives(avatar, seed, options);
    return avatar;
}

}  // namespace dpl::test
