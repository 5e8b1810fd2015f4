// SPDX-License-Identifier: Apache-2.0
// Conversions between rotation vectors (axis times angle in radians) and unit quaternions.
#pragma once

#include <cmath>

#include "sdk/math/types.h"

namespace dpl {

inline Quatd turnQuaternion(const Vec3d& w) {
    const double angle = glm::length(w);
    return angle > 1e-12 ? glm::angleAxis(angle, w / angle) : Quatd(1, 0, 0, 0);
}

/** Rotation vector of a unit quaternion, radians; the angle is at most π. */
inline Vec3d logQuaternion(Quatd q) {
    if (q.w < 0) q = -q;
    const Vec3d v(q.x, q.y, q.z);
    const double sine = glm::length(v);
    return sine < 1e-9 ? 2.0 * v : v * (2 * std::atan2(sine, q.w) / sine);
}

}  // namespace dpl
