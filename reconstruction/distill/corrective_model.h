// SPDX-License-Identifier: Apache-2.0
// The frame in which pose correctives are learned: modes of the training poses, and control nodes on the mesh. Nothing is learned here.
//
//   poses ─► features of the body's joints ─► principal components ─► K modes of unit variance, so that ‖k‖ is a Mahalanobis distance
//   mesh  ─► farthest-point nodes along the surface ─► four nearest nodes a vertex, weights (1 − d/d₅)²
#pragma once

#include <span>

#include "sdk/avatar/pose_correctives.h"
#include "sdk/core/result.h"

namespace dpl {

struct CorrectiveModelSettings {
    uint32_t maxModes = 12;
    double minVariance = 0.01;   // modes that explain less of the poses' variance are noise of the fit: another motion would blow them up
    double reachQuantile = 0.8;  // poses farther from the mean than this share of the training poses are shortened
    double offModesQuantile =
        0.95;  // poses farther off the modes than this share of the training poses are another motion: correctives fade
    double minReachOffModes = 0.05;  // about 2 degrees of one joint: poses that agree to less tell nothing about strange ones
    double nodeSpacingM = 0.03;      // about a fold of cloth; at 0.045 scan-a loses 0.3 dB, 0.02 gains 0.05 (docs/adr/0003)
    uint32_t minPoses = 12;          // fewer say nothing about how a surface follows its pose
    double minSpread = 0.1;          // root mean square of the feature's first component (radians for small turns): less is a held pose
};

/** Correctives with all nodes at zero, or empty ones when the poses are too few or too alike. Joints heard: the humanoid's body without
 *  hips, hands, toes, jaw and eyes. Deterministic. InvalidArgument: poses that do not fit the rig. */
Result<PoseCorrectiveData> correctiveModel(std::span<const JointData> joints, const MeshData& mesh, std::span<const Pose> poses,
                                           const CorrectiveModelSettings& settings = {});

}  // namespace dpl
