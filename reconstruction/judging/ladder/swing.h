// SPDX-License-Identifier: Apache-2.0
// How a hem swings beside the true one: how far, and how late (docs/reference/metrics.md, "Swing of the hem").
#pragma once

#include <span>
#include <vector>

#include "sdk/math/types.h"

namespace dpl {

/** Places of parts of a hem at one time, in the horizontal plane of the hips, metres. */
struct SwingSample {
    double timeS = 0;
    std::vector<Vec2d> parts;
};

/** Both swings are about their own means over the times that are compared. */
struct Swing {
    double trueRmsM = 0;     // of the true swing, over parts and times
    double amplitude = 0;    // root mean square of the avatar's swing over that of the truth
    double lateS = 0;        // shift in time at which both are most alike; above 0 the avatar is late
    double correlation = 0;  // at that shift; near 0 the shift says nothing
    size_t times = 0;        // that were compared there
};

/** Compares the swing of an avatar with the true one. Both must be of rising times and of the same parts; between two times the avatar goes
 *  straight. Shifts go from −mostLateS to mostLateS by 5 ms; one counts where at least three quarters of the true times, and four, fall
 *  within the avatar's. All zero when none does, or when the true swing is below a micrometre. */
Swing compareSwing(std::span<const SwingSample> truth, std::span<const SwingSample> avatar, double mostLateS);

}  // namespace dpl
