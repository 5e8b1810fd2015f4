// SPDX-License-Identifier: Apache-2.0
// Priors on the pose: which joints rotate, about which anatomical axes, how far and how fast. The values are rounded standard deviations of
// everyday motion: wide where keypoints determine the joint well (hips, shoulders), tight where they do not (twist, sideways bend of a
// hinge).
#pragma once

#include <vector>

#include "reconstruction/subject/body/body_model.h"

namespace dpl {

struct JointPrior {
    uint32_t joint = 0;
    Mat3d axes{1};        // columns: the anatomical axes in the rest frame; the prior acts on axesᵀ·w
    Vec3d sigmaRad{0.3};  // standard deviation about the rest pose
    Vec3d tailSigmas{0};  // 0: Gaussian; else the scale in σ of a Geman–McClure loss, for joints that either rest or clearly move
    Vec3d lowRad{-3.1}, highRad{3.1};  // range about the rest pose
    double accelerationRadS2 = 2;      // standard deviation of the angular acceleration
    double swayRad = 0;                // standard deviation between still frames; 0: does not sway
    double shakenRadS2 = 0;  // of the angular acceleration in frames that show a shaken head (MovingFrame::headShakes); 0: of no head
};

/** Priors of the joints that the fit rotates, in joint order: those with a humanoid name except root, fingers, toes, eyes and jaw. */
std::vector<JointPrior> posePriors(const BodyModel& body);
/** The joints of these priors. */
std::vector<uint32_t> jointsOf(const std::vector<JointPrior>& priors);

}  // namespace dpl
