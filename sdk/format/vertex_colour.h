// COLOR_0 of glTF is linear light; ours is sRGB bytes. 16 bits keep every sRGB byte apart, so the way there and back is exact. Internal.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace dpl {

inline uint16_t linearFromSrgb8(uint8_t srgb) {
    const double x = srgb / 255.0;
    return uint16_t(std::lround(65535 * (x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4))));
}

inline uint8_t srgb8FromLinear(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    return uint8_t(std::lround(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055)));
}

}  // namespace dpl
