// SPDX-License-Identifier: Apache-2.0
// Pose correctives: surface offsets and brightness that follow the pose (formula in PoseCorrectiveData, docs/reference/correctives.md).
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/correctives.h"

namespace dpl {

constexpr float kMinLight = 0.2f, kMaxLight = 3.0f;  // brightness is clamped to this (docs/reference/correctives.md)

/** What a joint's local rotation says: its first two columns minus the identity's, six numbers. */
template <class T>
inline void correctiveFeature(const glm::qua<T>& localRotation, T feature[6]) {
    const Mat3<T> r = glm::mat3_cast(glm::normalize(localRotation));
    for (int i = 0; i < 3; ++i) feature[i] = r[0][i] - T(i == 0), feature[3 + i] = r[1][i] - T(i == 1);
}

/** How far a pose is from those that were learned from. */
struct CorrectiveDistance {
    float length = 0;    // ‖k‖ before it is shortened
    float offModes = 0;  // distance of its features from what the modes span
};

/** The K numbers of a pose, shortened to `reach` and faded beyond `reachOffModes`. The pose must have passed checkPose. */
CorrectiveDistance correctiveCoefficients(const PoseCorrectiveData& correctives, const Pose& pose, std::vector<float>& coefficients);

/** Control nodes of those numbers: offset in metres, change of brightness. */
void correctiveNodes(const PoseCorrectiveData& correctives, std::span<const float> coefficients, std::vector<Vec4f>& nodes);

/** Spreads the nodes to the vertices: moved rest positions, and brightness clamped to [kMinLight, kMaxLight]. */
void spreadCorrectives(const PoseCorrectiveData& correctives, std::span<const Vec4f> nodes, std::span<const Vec3f> restPositions,
                       Jobs& jobs, std::vector<Vec3f>& moved, std::vector<float>& light);

}  // namespace dpl
