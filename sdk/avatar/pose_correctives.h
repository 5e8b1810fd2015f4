// SPDX-License-Identifier: Apache-2.0
// Pose correctives: surface offsets and brightness that follow the pose. Formulas: docs/reference/correctives.md.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/correctives.h"

namespace dpl {

constexpr float kMinLight = 0.2f, kMaxLight = 3.0f;  // limits of the brightness factor

/** Feature of a joint's local rotation: the first two columns of its matrix minus those of the identity, six numbers. */
template <class T>
inline void correctiveFeature(const glm::qua<T>& localRotation, T feature[6]) {
    const Mat3<T> r = glm::mat3_cast(glm::normalize(localRotation));
    for (int i = 0; i < 3; ++i) feature[i] = r[0][i] - T(i == 0), feature[3 + i] = r[1][i] - T(i == 1);
}

/** How far a pose lies from the training poses, before any limit. */
struct CorrectiveDistance {
    float length = 0;    // ‖k‖, length of the coefficients
    float offModes = 0;  // distance of its features from the span of the modes
};

/** The coefficients of a pose: K, shortened to `reach` and faded beyond `reachOffModes`; then K' of the motion modes, settled
 *  (motion_state.h). The pose must have passed checkPose. */
CorrectiveDistance correctiveCoefficients(const PoseCorrectiveData& correctives, const Pose& pose, std::vector<float>& coefficients);

/** Values of the M control nodes for these coefficients: offset in metres (xyz), change of brightness (w). */
void correctiveNodes(const PoseCorrectiveData& correctives, std::span<const float> coefficients, std::vector<Vec4f>& nodes);

/** Interpolates the nodes at the vertices. moved: V rest positions plus offsets. light: V factors, clamped to [kMinLight, kMaxLight]. */
void spreadCorrectives(const PoseCorrectiveData& correctives, std::span<const Vec4f> nodes, std::span<const Vec3f> restPositions,
                       Jobs& jobs, std::vector<Vec3f>& moved, std::vector<float>& light);

}  // namespace dpl
