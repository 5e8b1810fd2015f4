// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/capture_zoom.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sdk/math/skinning.h"

namespace dpl {

float nearestDistanceM(const CaptureMapData& map, std::span<const JointData> joints, std::span<const Mat3x4f> worldFromRest,
                       const Vec3f& point, const Vec3f& toEye, float focalPx, float magnification) {
    const CaptureSide* sides = nullptr;
    const Mat3x4f* pose = nullptr;
    float coarsest = 0, nearest = std::numeric_limits<float>::infinity();
    for (size_t j = 0; j < joints.size() && !map.sides.empty(); ++j) {
        const CaptureSide* of = &map.sides[j * kCaptureSides];
        float worst = 0;
        for (size_t s = 0; s < kCaptureSides; ++s) worst = std::max(worst, of[s].detailM);
        if (!(worst > 0)) continue;  // a joint without surface of its own
        const float away = glm::length(transformed(worldFromRest[j], joints[j].restPosition) - point);
        if (away < nearest) nearest = away, sides = of, pose = &worldFromRest[j], coarsest = worst;
    }
    if (!sides) return 0;
    const Vec3f atRest = glm::transpose(Mat3f((*pose)[0], (*pose)[1], (*pose)[2])) * toEye;
    const float across[kCaptureSides] = {std::max(0.0f, atRest.z), std::max(0.0f, atRest.x), std::max(0.0f, -atRest.z),
                                         std::max(0.0f, -atRest.x)};
    float sum = 0, logSize = 0;
    for (size_t s = 0; s < kCaptureSides; ++s) {
        const float weight = across[s] * across[s] + 1e-6f * glm::dot(atRest, atRest);  // from straight above all sides count alike
        logSize += weight * std::log(sides[s].detailM > 0 ? sides[s].detailM : coarsest);
        sum += weight;
    }
    return sum > 0 ? std::exp(logSize / sum) * focalPx / magnification : 0;
}

}  // namespace dpl
