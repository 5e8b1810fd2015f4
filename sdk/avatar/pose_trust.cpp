// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/pose_trust.h"

#include <algorithm>
#include <cmath>

namespace dpl {
namespace {

constexpr float kLeastSpread = 0.0524f;  // 3°: a feature of a small rotation about one axis is √2 or 1 times the angle in radians

}  // namespace

void poseTrust(const PoseCorrectiveData& c, const Pose& pose, PoseTrust& trust) {
    std::vector<float> coefficients;
    const CorrectiveDistance distance = correctiveCoefficients(c, pose, coefficients);
    const auto over = [](float value, float limit) { return limit > 0 ? value / limit : value > 0 ? 1e6f : 0.0f; };
    trust.away = over(distance.length, c.reach);
    trust.offModes = over(distance.offModes, c.reachOffModes);
    trust.offsets = 1 / (std::max(trust.away, 1.0f) * std::max(trust.offModes, 1.0f));
    trust.joints.assign(pose.localRotations.size(), -1.0f);
    const size_t features = c.joints.size() * 6;
    std::vector<float> squaredNorms(c.modeCount, 0.0f);
    for (uint32_t i = 0; i < c.modeCount; ++i)
        for (size_t f = 0; f < features; ++f) squaredNorms[i] += c.modes[i * features + f] * c.modes[i * features + f];
    for (size_t j = 0; j < c.joints.size(); ++j) {
        float feature[6], away = 0, variance = 0;
        correctiveFeature(pose.localRotations[c.joints[j]], feature);
        for (size_t f = 0; f < 6; ++f) {
            const float d = feature[f] - c.mean[j * 6 + f];
            away += d * d;
            // A mode is its principal direction over its standard deviation, so the covariance is Σ mode·modeᵀ / ‖mode‖⁴.
            for (uint32_t i = 0; i < c.modeCount; ++i)
                if (squaredNorms[i] > 0) {
                    const float m = c.modes[i * features + j * 6 + f] / squaredNorms[i];
                    variance += m * m;
                }
        }
        trust.joints[c.joints[j]] = std::sqrt(away) / std::max(std::sqrt(variance), kLeastSpread);
    }
}

}  // namespace dpl
