// SPDX-License-Identifier: Apache-2.0
// Conversion between float and IEEE 754 binary16.
#pragma once

#include <bit>
#include <cstdint>

namespace dpl {

/** Every half has an exact float. */
inline float floatFromHalf(uint16_t half) {
    const uint32_t sign = uint32_t(half & 0x8000) << 16, exponent = half >> 10 & 31, mantissa = half & 1023;
    if (exponent == 0) {  // zero and denormals: steps of 2⁻²⁴
        const float magnitude = float(mantissa) * 0x1p-24f;
        return sign ? -magnitude : magnitude;
    }
    return std::bit_cast<float>(sign | (exponent == 31 ? 255u : exponent + 112) << 23 | mantissa << 13);
}

/** Rounds to nearest, ties to even. Magnitudes from 65520 on become infinite; NaN stays NaN. */
inline uint16_t halfFromFloat(float x) {
    const uint32_t bits = std::bit_cast<uint32_t>(x), sign = bits >> 16 & 0x8000, magnitude = bits & 0x7FFFFFFF;
    if (magnitude > 0x7F800000) return uint16_t(sign | 0x7E00);
    if (magnitude >= 0x477FF000) return uint16_t(sign | 0x7C00);
    if (magnitude < 0x38800000)  // below 2⁻¹⁴: floats in [½, 1) have the step 2⁻²⁴ of denormal halves, so adding ½ rounds
        return uint16_t(sign | (std::bit_cast<uint32_t>(std::bit_cast<float>(magnitude) + 0.5f) - 0x3F000000));
    return uint16_t(sign | (magnitude - (112u << 23) + 0xFFF + (magnitude >> 13 & 1)) >> 13);
}

}  // namespace dpl
