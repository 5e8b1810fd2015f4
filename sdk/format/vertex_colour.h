// SPDX-License-Identifier: Apache-2.0
// Converts vertex colours between sRGB bytes and the linear light of glTF's COLOR_0. 16 bits tell all sRGB bytes apart, so the round trip
// is exact. Internal.
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
