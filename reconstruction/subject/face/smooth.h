// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace dpl {

/** 0 at `from`, 1 at `to`, smooth at both. */
inline float smooth(float from, float to, float x) {
    const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

}  // namespace dpl
