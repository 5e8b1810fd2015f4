// SPDX-License-Identifier: Apache-2.0
// Backward of the pose correctives: rest positions and brightness of the vertices -> control nodes -> the pose that moved them.
#pragma once

#include "sdk/avatar/pose_correctives.h"

namespace dpl {

/** ∂loss/∂nodes (M: offset, brightness) of one pose, summed in vertex order. nodes: those of the pose (brightness is clamped, and a clamped
 *  vertex passes nothing on). gRest, gLight: gradients on what spreadCorrectives() gave. */
void gatherNodes(const PoseCorrectiveData& correctives, std::span<const Vec4f> nodes, std::span<const Vec3f> gRest,
                 std::span<const float> gLight, std::vector<Vec4f>& gNodes);

/** Adds to rotation[j] (R_j ← exp(ω)·R_j, parent axes) what the pose does through its coefficients, shortening and fading included. */
void addCorrectivePoseGradient(const PoseCorrectiveData& correctives, const Pose& pose, std::span<const Vec4f> gNodes,
                               std::span<Vec3d> rotation);

}  // namespace dpl
