// SPDX-License-Identifier: Apache-2.0
// Random but reproducible expressions for any avatar, on the control nodes of its pose correctives or on nodes of their own.
#pragma once

#include <random>

#include "sdk/avatar/rig.h"
#include "sdk/format/expressions.h"
#include "sdk/format/face_nodes.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl::test {

/** `count` shapes, each of about half of the nodes, with offsets of about offsetM. */
inline AvatarData withExpressions(AvatarData avatar, uint32_t seed, uint32_t count = 5, float offsetM = 0.01f) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    if (avatar.correctives.empty()) {
        PoseCorrectiveData c = randomCorrectives(avatar, seed, {.nodes = 8});
        PoseCorrectiveData own;
        own.nodeCount = c.nodeCount, own.nodeIndices = std::move(c.nodeIndices), own.nodeWeights = std::move(c.nodeWeights);
        own.nodeIndices[0] = glm::u16vec4(0), own.nodeWeights[0] = glm::u8vec4(255, 0, 0, 0);  // a vertex that never moves
        avatar.correctives = std::move(own);
    }
    ExpressionData& x = avatar.expressions;
    for (uint32_t s = 0; s < count; ++s) {
        x.shapes.push_back(uint8_t(s * (kExpressionCount - 1) / std::max(1u, count - 1)));
        for (uint32_t n = avatar.correctives.followsPose() ? 0 : 1; n < avatar.correctives.nodeCount; ++n) {
            if (random() % 2) continue;
            x.nodes.push_back(uint16_t(n));
            x.offsetsM.push_back(glm::clamp(offsetM * Vec3f(normal(random), normal(random), normal(random)), -0.099f, 0.099f));
        }
        x.ends.push_back(uint32_t(x.nodes.size()));
    }
    return avatar;
}

/** `count` shapes on nodes of the face's own, in turn small enough for bytes and too large for them. Vertex 0 never moves. */
inline AvatarData withOwnFace(AvatarData avatar, uint32_t seed, uint32_t count = 6) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> share(-1, 1);
    const auto vertexCount = uint32_t(avatar.mesh.restPositions.size()), nodes = std::min(7u, vertexCount / 2);
    std::vector<FaceVertex> on;
    for (uint32_t v = 1; v < vertexCount; ++v) {
        if (v <= nodes)
            on.push_back({v, glm::u16vec4(uint16_t(nodes - v), 0, 0, 0), glm::u8vec4(255, 0, 0, 0)});
        else if (v % 3)
            on.push_back({v, glm::u16vec4(uint16_t(v % nodes), uint16_t((v + 1) % nodes), 0, 0), glm::u8vec4(200, 55, 0, 0)});
    }
    ExpressionData& x = avatar.expressions;
    if (!bindToFace(on, nodes, vertexCount, avatar.correctives, x)) return avatar;  // without a face, which no test takes for one
    for (uint32_t s = 0; s < count; ++s) {
        x.shapes.push_back(uint8_t(s * (kExpressionCount - 1) / std::max(1u, count - 1)));
        const float most = s % 2 ? 0.09f : kByteRangeM;
        for (uint32_t n = s % 2; n < nodes; ++n) {
            x.nodes.push_back(uint16_t(x.firstNode + n));
            x.offsetsM.push_back(most * Vec3f(share(random), share(random), share(random)));
        }
        x.ends.push_back(uint32_t(x.nodes.size()));
    }
    return avatar;
}

inline ExpressionWeights randomWeights(std::mt19937& random) {
    std::uniform_real_distribution<float> share;
    ExpressionWeights weights;
    for (float& weight : weights) weight = share(random);
    return weights;
}

}  // namespace dpl::test
