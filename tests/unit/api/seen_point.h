// SPDX-License-Identifier: Apache-2.0
// Where a DplCamera sees a point, as doppel.h defines it, in double.
#pragma once

#include <array>

#include "sdk/include/doppel/doppel.h"

namespace dpl::test {

using Vector = std::array<double, 3>;

/** Pixel (x, y) and view z of a point of the world. */
inline Vector seen(const DplCamera& camera, const Vector& world) {
    double v[3];
    for (int row = 0; row < 3; ++row) {
        const float* m = camera.viewFromWorld + 4 * row;
        v[row] = m[0] * world[0] + m[1] * world[1] + m[2] * world[2] + m[3];
    }
    return {camera.fx * v[0] / v[2] + camera.cx, camera.fy * v[1] / v[2] + camera.cy, v[2]};
}

}  // namespace dpl::test
