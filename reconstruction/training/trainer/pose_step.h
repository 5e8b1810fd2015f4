// SPDX-License-Identifier: Apache-2.0
// One step of a pose along the gradient of a picture's loss, with the pull of registration. Training and the test-time pose fit share it.
//
//   d' = d − r·m̂/√v̂                                   Adam on the picture's gradient alone
//   d  = argmin ½ Σ √v̂/r (x − d')² + ½ s xᵀH x         proximal step in Adam's own metric
//
// d is the deviation from the registered pose, H its precision, s the loss per nat. Adam would rescale the gradient of a penalty. Here both
// steps use the same metric, so that it cancels: at rest ∂loss/∂d + s·H·d = 0.
#pragma once

#include "reconstruction/input/capture/pose_precision.h"
#include "reconstruction/training/trainer/adam.h"
#include "reconstruction/training/trainer/backward_mesh.h"
#include "sdk/avatar/rig.h"

namespace dpl {

struct PoseRates {
    double rotation = 0, translation = 0;  // rad, metres
};

/** The registered pose and what a deviation from it costs. */
struct PosePull {
    const Pose& registered;
    const PosePrecision* precision = nullptr;  // null: no pull, and every joint may turn; else its joints alone do
    double lossPerNat = 0;
};

/** The loss that one nat of a picture's likelihood is worth. The picture counts as independent residuals with a Laplace spread that it
 *  tells itself: −ln p = trust · pixels · ln(loss), so a nat is loss / (trust · pixels). personPx: the person's pixels.
 *  trust: how many residuals each of them counts as. */
double lossPerNat(double loss, double personPx, double trust);

/** A precision in which a deviation of the root along the unit vector `direction` (world) costs `times` as much: DHD, where D
 *  stretches the root's translation along it by √times. times: above 0. */
PosePrecision heldAlong(PosePrecision precision, const Vec3d& direction, double times);

/** Moves `pose`. `gradient`: ∂loss/∂(left turn of each joint, translation of the root). Where it is not finite, or its square is not,
 *  pose and moments stay; where the pull has no finite solution, the pose stays. */
void stepPose(Pose& pose, AdamVector& adam, const PoseGradient<double>& gradient, const PoseRates& rates, const PosePull& pull);

/** ½ dᵀHd of a pose, nats. */
double costOfDeviation(const Pose& pose, const PosePull& pull);

}  // namespace dpl
