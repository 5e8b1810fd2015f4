// SPDX-License-Identifier: Apache-2.0
// Backward pass of the light of the scene: from a vertex's brightness to that of the correctives, and to its posed normal.
#pragma once

#include "sdk/avatar/posed_mesh.h"

namespace dpl {

/** gLight: V; on entry ∂loss/∂(drawn brightness), afterwards ∂loss/∂(brightness of the correctives). gNormals: V, resized; ∂loss/∂(normal
 * as turnedNormal() gives it). Both are zero where the drawn brightness is clamped. Normals at rest count as constants. posed: of a subject
 * with this light and these normals. */
void backwardLight(const MeshData& mesh, const LightData& light, std::span<const Vec3f> normals, const PosedMesh& posed,
                   std::span<float> gLight, std::vector<Vec3f>& gNormals);

}  // namespace dpl
