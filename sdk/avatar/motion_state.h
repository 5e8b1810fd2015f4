// SPDX-License-Identifier: Apache-2.0
// What cloth remembers of the poses before this one, as a pure function. Formulas: docs/reference/correctives.md, "Motion modes".
//
//   (state, pose, seconds) ─► state ─► K' coefficients behind the K of the pose
//
// A state is a fixed block of doubles that is computed in a fixed order: the same poses and times give the same bytes. Nothing allocates.
// The leaks are exact for any step of time, so no rate makes a state grow.
#pragma once

#include <array>
#include <span>

#include "sdk/avatar/rig.h"
#include "sdk/format/motion_modes.h"

namespace dpl {

/** Held inputs, 1 + J of each hold in a row: whether the subject has moved, then how far each joint was turned. All 0 in the still pose. */
struct MotionState {
    std::array<double, kMaxMotionHolds*(1 + kMaxMotionJoints)> held{};
};

/** The state of a pose alone: as if it had been held for ever. Used where no time is known. The motion modes must have passed
 *  checkMotionModes, the pose checkPose. */
void settleMotion(const MotionModeData& motion, const Pose& pose, MotionState& state);

/** The state `seconds` after `state`, now in this pose. 0 seconds: a pose that is set twice for one time changes nothing. Time that runs
 *  backwards, or is not finite, settles. Preconditions as above; `state` is one of the same motion modes. */
void advanceMotion(const MotionModeData& motion, const Pose& pose, double seconds, MotionState& state);

/** The K' coefficients of a state, shortened to the reach of each group. coefficients: K' entries. */
void motionCoefficients(const MotionModeData& motion, const MotionState& state, std::span<float> coefficients);

/** Adds to `rotation` (J of the rig: ∂loss/∂ left turn of each joint) the gradient through the settled state. gCoefficients: K' entries,
 *  ∂loss/∂k'. At rest, and where an input has reached its most, it is zero. */
void addSettledMotionGradient(const MotionModeData& motion, const Pose& pose, std::span<const double> gCoefficients,
                              std::span<Vec3d> rotation);

}  // namespace dpl
