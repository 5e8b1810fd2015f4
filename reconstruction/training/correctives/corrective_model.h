// SPDX-License-Identifier: Apache-2.0
// The basis of pose correctives: modes of the training poses and control nodes on the mesh. Training fills in the values later.
// docs/reference/correctives.md
//
//   poses ─► features of the body's joints ─► principal components ─► K modes of unit variance, so that ‖k‖ is a Mahalanobis distance
//   mesh  ─► farthest-point nodes along the surface ─► four nearest nodes a vertex, weights (1 − d/d₅)²
#pragma once

#include <span>

#include "reconstruction/training/correctives/priors.h"
#include "sdk/avatar/pose_correctives.h"
#include "sdk/core/result.h"

namespace dpl {

struct CorrectiveModelSettings {
    uint32_t maxModes = 12;
    double minVariance = 0.01;       // share of the poses' variance; smaller modes are noise of the fit, which other motions would amplify
    double reachQuantile = 0.8;      // quantile of the training poses' distances from the mean; farther poses are scaled back
    double offModesQuantile = 0.95;  // quantile of the distances off the modes; correctives fade for poses farther off
    double minReachOffModes = 0.05;  // lower limit of that distance: about 2 degrees of one joint
    double nodeSpacingM = priors::kNodeSpacingM;
    uint32_t minPoses = 12;  // with fewer poses the result is empty
    double minSpread = 0.1;  // RMS of the first principal component (radians for small angles); with less the result is empty
};

/** Returns correctives whose nodes are all zero, or empty correctives when the poses are too few or too alike. Features come from the
 *  humanoid joints except hips, hands, toes, jaw and eyes. Deterministic. InvalidArgument when the poses do not match the rig. */
Result<PoseCorrectiveData> correctiveModel(std::span<const JointData> joints, const MeshData& mesh, std::span<const Pose> poses,
                                           const CorrectiveModelSettings& settings = {});

}  // namespace dpl
