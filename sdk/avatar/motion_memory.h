// SPDX-License-Identifier: Apache-2.0
// What cloth remembers, as numbers. Formulas: docs/reference/correctives.md, "Motion modes". Functions: motion_state.h.
#pragma once

#include <array>

#include "sdk/format/motion_modes.h"

namespace dpl {

/** Of clothes: a factor of what they learned, 0 to this; 1: as learned. Beyond the reach of training by at most the other. */
constexpr float kMostClothStiffness = 100;
constexpr double kMostMotionOverReach = 1.3;

using HeldInputs = std::array<double, kMaxMotionHolds*(1 + kMaxMotionJoints)>;
using Turns = std::array<double, 6 * kMaxMotionJoints>;
using LaggedTurns = std::array<double, kMaxMotionLags * 6 * kMaxMotionJoints>;

/** What is left of a state when the next pose comes. All 0: nothing, so the next state is settled. */
struct MotionMemory {
    HeldInputs held{};                             // of each hold 1 + J in a row: has moved, then how far each joint was turned
    LaggedTurns lagged{};                          // of each lag 6·J: its part that is of earlier poses
    std::array<double, kMaxMotionLags> earlier{};  // of each lag: their share; 1 minus it is that of the next pose

    bool operator==(const MotionMemory&) const = default;
};

/** What cloth knows in a pose. In the still pose, held for long, all of `held` is 0, and `lagged` repeats `turns`. */
struct MotionState {
    HeldInputs held{};
    LaggedTurns lagged{};  // where turns were, smoothed over each lag
    Turns turns{};         // where they are: 6 numbers a joint (correctiveFeature)

    bool operator==(const MotionState&) const = default;
};

}  // namespace dpl
