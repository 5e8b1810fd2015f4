// SPDX-License-Identifier: Apache-2.0
// Backward pass of the pose correctives: from rest positions and brightness of the vertices to the control nodes, and from these to the
// pose. And of the light of the scene, which counts as constant in a pose (docs/reference/light.md).
#pragma once

#include "sdk/avatar/posed_mesh.h"

namespace dpl {

/** From ∂loss/∂(drawn brightness) to ∂loss/∂(brightness of the correctives), V, in place: zero where the drawn brightness is clamped.
 *  posed: of the pass. Nothing happens without light of the scene. */
void backwardSceneLight(const PosedMesh& posed, std::span<float> gLight);

/** ∂loss/∂nodes of one pose: M entries of offset (xyz) and brightness (w), summed in vertex order. nodes: the node values of this pose.
 *  gRest, gLight: gradients on the offsets and brightness that spreadCorrectives() made of them, one a vertex. A vertex whose brightness
 *  was clamped contributes no brightness gradient. */
void gatherNodes(const PoseCorrectiveData& correctives, std::span<const Vec4f> nodes, std::span<const Vec3f> gRest,
                 std::span<const float> gLight, std::vector<Vec4f>& gNodes);

/** Adds to rotation[j] the gradient through the pose's mode coefficients, with their shortening and fading. rotation[j] belongs to
 *  R_j ← exp(ω)·R_j, with ω along the axes of the parent's frame. */
void addCorrectivePoseGradient(const PoseCorrectiveData& correctives, const Pose& pose, std::span<const Vec4f> gNodes,
                               std::span<Vec3d> rotation);

}  // namespace dpl
