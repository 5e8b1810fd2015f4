// SPDX-License-Identifier: Apache-2.0
// What human joints usually do: which turn, about which anatomical axes, how far, how fast. Numbers are standard deviations of everyday
// motion in round figures, loose where keypoints see the joint well (hips, shoulders), tight where they do not (twist, side bend of a
// hinge).
#pragma once

#include <vector>

#include "reconstruction/body/body_model.h"

namespace dpl {

struct JointPrior {
    uint32_t joint = 0;
    Mat3d axes{1};        // columns: the anatomical axes in the rest frame; the prior acts on axesᵀ·w
    Vec3d sigmaRad{0.3};  // spread about the rest pose
    Vec3d tailSigmas{0};  // an axis with 0 is Gaussian, else Geman–McClure of this scale: "near the still pose, or clearly moved"
    Vec3d lowRad{-3.1}, highRad{3.1};  // range, rest at 0
    double accelerationRadS2 = 2;      // spread of the angular acceleration
    double swayRad = 0;                // spread between "still" frames; 0: this joint does not sway
};

/** The joints that the fit turns, in joint order, without the root: those with a humanoid name, no fingers, toes, eyes or jaw. */
std::vector<JointPrior> posePriors(const BodyModel& body);

}  // namespace dpl
