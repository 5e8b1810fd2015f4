// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/garments/hanging_hair.h"

#include <algorithm>

#include "reconstruction/subject/garments/priors.h"
#include "sdk/format/skin_weights.h"
#include "sdk/math/skinning.h"

namespace dpl {
namespace {

// From the head joint, which lies where the spine meets the skull.
constexpr float kEarsAboveM = 0.04f, kChinBelowM = 0.1f;

/** Of each vertex, metres below the ears of the upright head; negative above. */
std::vector<float> dropsM(const SurfaceMesh& piece, const Vec3f& headAtRest, const Mat3x4f& worldFromHead) {
    const Mat3f turn(worldFromHead[0], worldFromHead[1], worldFromHead[2]);
    std::vector<float> drops;
    for (const Vec3f& p : piece.positions) drops.push_back(headAtRest.y + kEarsAboveM - (glm::transpose(turn) * (p - worldFromHead[3])).y);
    return drops;
}

}  // namespace

void hangFromHead(const SurfaceMesh& piece, std::span<const JointData> joints, std::span<const Mat3x4f> worldFromRest,
                  ClothWeights& weights) {
    const auto head = std::ranges::find(joints, std::string("head"), &JointData::humanoidBone);
    if (head == joints.end() || piece.positions.empty()) return;
    const auto joint = uint32_t(head - joints.begin());
    const std::vector<float> drops = dropsM(piece, head->restPosition, worldFromRest[joint]);
    if (std::ranges::max(drops) < kEarsAboveM + kChinBelowM) return;
    for (size_t v = 0; v < drops.size(); ++v) {
        const float t =
            std::clamp((drops[v] - priors::kHairFollowsHeadM) / (priors::kHairFollowsBodyM - priors::kHairFollowsHeadM), 0.0f, 1.0f);
        const float body = t * t * (3 - 2 * t);
        if (!(body < 1)) continue;
        std::vector<std::pair<uint32_t, float>> mixed{{joint, 1 - body}};
        for (int i = 0; i < 4; ++i) mixed.emplace_back(weights.joints[v][i], body * float(weights.weights[v][i]) / 255);
        const PackedWeights packed = packWeights(mixed);
        weights.joints[v] = packed.joints, weights.weights[v] = packed.weights;
    }
}

}  // namespace dpl
