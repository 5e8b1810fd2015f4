// SPDX-License-Identifier: Apache-2.0
// How well the finger fit knows the fingers of one frame, as training needs it to turn them.
#pragma once

#include "reconstruction/input/capture/pose_precision.h"
#include "reconstruction/subject/hands/finger_cost.h"

namespace dpl {

/** The precision JᵀJ of a frame's turns at the fit, the wrist's own turn and shift summed out (Schur complement): of its points and of the
 *  prior. Turns keep room to their limits: a standard deviation is at most the way to the nearer one. prior: standard deviations of the
 *  turns against what they are drawn to, radians. */
std::array<double, kHandTurns * kHandTurns> turnPrecision(const HandRig& hand, const HandView& view, const HandTurns& turns,
                                                          const std::array<double, kWristSize>& wrist, const HandTurns& prior);

/** The same as the precision of joints. They turn about their hinges; about any other axis a joint is held. */
PosePrecision jointPrecision(const HandRig& hand, const HandTurns& turns, const std::array<double, kHandTurns * kHandTurns>& precision);

}  // namespace dpl
