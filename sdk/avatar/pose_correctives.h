// SPDX-License-Identifier: Apache-2.0
// Pose correctives: surface offsets and brightness that follow the pose. Formulas: docs/reference/correctives.md.
#pragma once

#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/avatar/rotation_feature.h"
#include "sdk/format/correctives.h"

namespace dpl {

constexpr float kMinLight = 0.2f, kMaxLight = 3.0f;  // limits of the brightness factor

/** How far a pose lies from the training poses. */
struct CorrectiveDistance {
    float length = 0;    // ‖k‖, length of the coefficients before any limit
    float offModes = 0;  // distance of its features from the span of the modes
    float drawn = 1;     // share of the coefficients that the limits leave, in [0, 1]; motion modes have limits of their own
};

/** The coefficients of a pose: K, shortened to `reach` and faded beyond `reachOffModes`; then K' of the motion modes, in the
 *  state of the pose (motion_state.h). The pose must have passed checkPose. */
CorrectiveDistance correctiveCoefficients(const PoseCorrectiveData& correctives, const Pose& pose, std::vector<float>& coefficients);

/** Values of the M control nodes for these coefficients: offset in metres (xyz), change of brightness (w). */
void correctiveNodes(const PoseCorrectiveData& correctives, std::span<const float> coefficients, std::vector<Vec4f>& nodes);

/** Adds the expressions of a pose to the nodes, and their S weights to the coefficients, behind the K + K' of the correctives. Weights of
 *  zero leave every byte of the nodes as it is. nodes: M, of correctiveNodes. */
void addExpression(const ExpressionData& expressions, const ExpressionWeights& weights, std::vector<float>& coefficients,
                   std::span<Vec4f> nodes);

/** Interpolates the nodes at the vertices. moved: V rest positions plus offsets. light: V factors, clamped to [kMinLight, kMaxLight]. */
void spreadCorrectives(const PoseCorrectiveData& correctives, std::span<const Vec4f> nodes, std::span<const Vec3f> restPositions,
                       Jobs& jobs, std::vector<Vec3f>& moved, std::vector<float>& light);

}  // namespace dpl
