// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "sdk/math/types.h"

namespace dpl {

/** Place (u, v) of the k-th of evenly spread points in a triangle: the R2 low-discrepancy sequence (the additive recurrence of the plastic
 *  number) from `start`, moved by `shift` and folded into the triangle. */
inline Vec2d spreadPlace(double start, uint32_t k, const Vec2d& shift = Vec2d(0)) {
    double u = start + 0.7548776662466927 * k + shift.x, v = start + 0.5698402909980532 * k + shift.y;
    u -= std::floor(u), v -= std::floor(v);
    return u + v > 1 ? Vec2d(1 - u, 1 - v) : Vec2d(u, v);
}

}  // namespace dpl
