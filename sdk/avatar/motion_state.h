// SPDX-License-Identifier: Apache-2.0
// What cloth remembers of the poses before this one, as pure functions. Formulas: docs/reference/correctives.md, "Motion modes".
//
//   state ─► forgetMotion(seconds) ─► Pose::before, with the next pose ─► stateOf ─► state ─► K' coefficients behind the K of the pose
//
// A state is a fixed block of doubles that is computed in a fixed order: the same poses and times give the same bytes. Nothing allocates.
// The leaks are exact for any step of time, so no rate makes a state grow.
#pragma once

#include <span>

#include "sdk/avatar/rig.h"

namespace dpl {

/** The state in a pose: its own inputs, or what is held of earlier ones (Pose::before) where that is more; and its turns, which lags
 * follow. With nothing remembered, it is as if the pose had been kept for ever: the settled state. The motion modes must have passed
 *  checkMotionModes, the pose checkPose. */
MotionState stateOf(const MotionModeData& motion, const Pose& pose);

/** What is left of a state after `seconds`, in which turns go evenly from those of the state to those of the next pose. 0 seconds: all of
 *  it, except of holds of 0 s. Time that runs backwards, or is not finite: nothing. */
MotionMemory forgetMotion(const MotionModeData& motion, const MotionState& state, double seconds);

/** What is left of a state where the next pose comes at an unknown time: what is held, and by how much turns lagged behind. */
MotionMemory carryMotion(const MotionModeData& motion, const MotionState& state);

/** What the modes of a state multiply: featureCount() numbers. */
void motionFeatures(const MotionModeData& motion, const MotionState& state, std::span<double> features);

/** The K' coefficients of a state, shortened to the reach of each group. coefficients: K' entries. stiffness: Pose::clothStiffness; they
 * are multiplied by 2/(1 + stiffness), and softer clothes may go beyond the reach by kMostMotionOverReach. */
void motionCoefficients(const MotionModeData& motion, const MotionState& state, std::span<float> coefficients, float stiffness = 1);

/** Adds to `rotation` (J of the rig: ∂loss/∂ left turn of each joint) the gradient through the state of the pose. gCoefficients: K'
 *  entries, ∂loss/∂k'. At rest, where an input has reached its most, and where more is held, it is zero. Stiffness 1. */
void addMotionGradient(const MotionModeData& motion, const Pose& pose, std::span<const double> gCoefficients, std::span<Vec3d> rotation);

}  // namespace dpl
