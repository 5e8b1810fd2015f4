// SPDX-License-Identifier: Apache-2.0
// What several files of the referee need of mathematics.
#pragma once

#include <algorithm>

#include "sdk/avatar/rig.h"

namespace dpl {

/** 0 up to `from`, 1 from `to` on (or the other way round where from > to), smooth at both ends. */
inline double referenceSmoothstep(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/** The rotation matrix of a quaternion of any length but 0. */
inline glm::dmat3 referenceRotation(const Quatf& rotation) {
    const double x = rotation.x, y = rotation.y, z = rotation.z, w = rotation.w;
    const double s = 2 / (x * x + y * y + z * z + w * w);
    return glm::dmat3(1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y),   // column 0
                      s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x),   // column 1
                      s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y));  // column 2
}

}  // namespace dpl
