// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace dpl {

/** 0 to 1 with zero speed and acceleration at both ends (quintic). */
inline double ease(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * t * (t * (6 * t - 15) + 10);
}

}  // namespace dpl
