// SPDX-License-Identifier: Apache-2.0
#include "sdk/avatar/pose_trust.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace dpl {
namespace {

constexpr float kLeastSpread = 0.0524f;  // 3°: a feature of a small rotation about one axis is √2 or 1 times the angle in radians

/** Variances of the training poses by joint of the feature, summed over its six numbers. */
float spreadOf(const PoseCorrectiveData& c, std::span<const float> squaredNorms, size_t joint) {
    const size_t features = c.joints.size() * 6;
    float variance = 0;
    // A mode is its principal direction over its standard deviation, so the covariance is Σ mode·modeᵀ / ‖mode‖⁴.
    for (uint32_t i = 0; i < c.modeCount; ++i)
        for (size_t f = 0; f < 6 && squaredNorms[i] > 0; ++f) {
            const float m = c.modes[i * features + joint * 6 + f] / squaredNorms[i];
            variance += m * m;
        }
    return std::max(std::sqrt(variance), kLeastSpread);
}

std::vector<float> squaredNormsOf(const PoseCorrectiveData& c) {
    const size_t features = c.joints.size() * 6;
    std::vector<float> norms(c.modeCount, 0.0f);
    for (uint32_t i = 0; i < c.modeCount; ++i)
        for (size_t f = 0; f < features; ++f) norms[i] += c.modes[i * features + f] * c.modes[i * features + f];
    return norms;
}

/** Length of a joint's six numbers of d. */
float awayFromMean(const PoseCorrectiveData& c, size_t joint, const Quatf& rotation) {
    float feature[6], away = 0;
    correctiveFeature(rotation, feature);
    for (size_t f = 0; f < 6; ++f) away += (feature[f] - c.mean[joint * 6 + f]) * (feature[f] - c.mean[joint * 6 + f]);
    return std::sqrt(away);
}

/** The rotation nearest to the mean feature: its columns made orthonormal. Identity if the mean has no directions. */
Quatf meanRotation(const PoseCorrectiveData& c, size_t joint) {
    const float* m = c.mean.data() + joint * 6;
    const Vec3f x(1 + m[0], m[1], m[2]), y(m[3], 1 + m[4], m[5]), z = glm::cross(x, y);
    if (!(glm::length(x) > 1e-3f) || !(glm::length(z) > 1e-3f)) return Quatf(1, 0, 0, 0);
    const Vec3f first = glm::normalize(x), third = glm::normalize(z);
    return glm::normalize(glm::quat_cast(Mat3f(first, glm::cross(third, first), third)));
}

}  // namespace

void poseTrust(const PoseCorrectiveData& c, const Pose& pose, PoseTrust& trust) {
    std::vector<float> coefficients;
    const CorrectiveDistance distance = correctiveCoefficients(c, pose, coefficients);
    const auto over = [](float value, float limit) { return limit > 0 ? value / limit : value > 0 ? 1e6f : 0.0f; };
    trust.away = over(distance.length, c.reach);
    trust.offModes = over(distance.offModes, c.reachOffModes);
    trust.offsets = distance.drawn;
    trust.joints.assign(pose.localRotations.size(), -1.0f);
    const std::vector<float> norms = squaredNormsOf(c);
    for (size_t j = 0; j < c.joints.size(); ++j)
        trust.joints[c.joints[j]] = awayFromMean(c, j, pose.localRotations[c.joints[j]]) / spreadOf(c, norms, j);
}

void holdPose(const PoseCorrectiveData& c, float limit, Pose& pose) {
    const std::vector<float> norms = squaredNormsOf(c);
    for (size_t j = 0; j < c.joints.size(); ++j) {
        const float allowed = limit * spreadOf(c, norms, j);
        Quatf& rotation = pose.localRotations[c.joints[j]];
        if (awayFromMean(c, j, rotation) <= allowed) continue;
        const Quatf mean = meanRotation(c, j), far = glm::normalize(rotation);
        float near = 0, beyond = 1;  // shares of the arc
        for (int i = 0; i < 20; ++i) {
            const float middle = 0.5f * (near + beyond);
            (awayFromMean(c, j, glm::slerp(mean, far, middle)) <= allowed ? near : beyond) = middle;
        }
        rotation = glm::normalize(glm::slerp(mean, far, near));
    }
}

}  // namespace dpl
