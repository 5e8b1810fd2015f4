// SPDX-License-Identifier: Apache-2.0
// The sRGB transfer function (IEC 61966-2-1) between display-referred values and linear light, both in [0,1]. Nothing is clamped.
#pragma once

#include <cmath>

namespace dpl {

inline double linearFromSrgb(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
inline double srgbFromLinear(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

}  // namespace dpl
