// SPDX-License-Identifier: Apache-2.0
// What the time between moving frames says about their poses: standing feet do not slide, and joints and root accelerate little. The body
// fit and the registration to pictures share these terms. Private to both rooms, as fit_costs.h.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/subject/body/fit_costs.h"

namespace dpl {

/** A moving frame of a problem. Its parameter blocks belong to the caller and must outlive the problem. */
struct MovingFrame {
    double timeS = 0;
    const Mat3d* reference = nullptr;  // of the root
    double* root = nullptr;            // kRootSize values
    double* pose = nullptr;            // three values for each joint prior
    bool free = true;                  // terms between frames that are not free are left out
    bool headShakes = false;           // accelerations of neck and head about here spread by JointPrior::shakenRadS2
};

struct MotionModel {
    const FitContext& context;
    const std::vector<JointPrior>& priors;
    std::span<const std::string> keypointNames;
    Vec3d up;       // the vertical, world
    double* shape;  // block of the body's shape
    AccelerationSpread spread;
};

/** Adds the terms between neighbours in time. `inTime`: ascending. Frames farther apart than kMaxGapS say nothing about each other. */
void addMotionTerms(ceres::Problem& problem, const MotionModel& model, std::span<const MovingFrame> inTime);

}  // namespace dpl
