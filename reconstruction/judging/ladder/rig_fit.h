// SPDX-License-Identifier: Apache-2.0
// Fits a pose to known places of skinned vertices.
#pragma once

#include <span>

#include "sdk/avatar/rig.h"

namespace dpl {

/** Finds joint rotations and root translation that bring the skinned vertices of `mesh` nearest to `targets` (one a vertex, metres):
 *
 *      min over θ, t of  Σ_v weight_v ‖skin(v; θ, t) − target_v‖² + pull · Σ_j ‖turn of joint j from `start`‖²
 *
 *  Gauss–Newton from `start`, damped where a step would not lower the cost. `pull` (m²/rad²) is small: it holds joints that no weighted
 *  vertex follows. weights: one a vertex, ≥ 0. Deterministic. `start` must have passed checkPose. */
Pose fitRig(std::span<const JointData> joints, const MeshData& mesh, std::span<const Vec3f> targets, std::span<const float> weights,
            const Pose& start);

}  // namespace dpl
