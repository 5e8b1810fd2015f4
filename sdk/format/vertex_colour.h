// SPDX-License-Identifier: Apache-2.0
// COLOR_0 of glTF is linear light; ours is sRGB bytes. 16 bits keep every sRGB byte apart, so the way there and back is exact. Internal.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "sdk/math/srgb.h"

namespace dpl {

inline uint16_t linearFromSrgb8(uint8_t srgb) {
    return uint16_t(std::lround(65535 * linearFromSrgb(srgb / 255.0)));
}
inline uint8_t srgb8FromLinear(double linear) {
    return uint8_t(std::lround(255 * srgbFromLinear(std::clamp(linear, 0.0, 1.0))));
}

}  // namespace dpl
