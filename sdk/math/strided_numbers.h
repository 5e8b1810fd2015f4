// SPDX-License-Identifier: Apache-2.0
// Numbers of a property in memory that somebody else laid out: one row an element, as floats or halves, at any alignment.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "sdk/math/half.h"

namespace dpl {

constexpr float kMaxHalf = 65504;

struct StridedNumbers {
    uint8_t* first = nullptr;  // the row of element 0
    size_t strideBytes = 0;    // from one row to the next
    bool half = false;

    /** Writes the row of an element. Numbers too large for a half become the largest one; returns how many did. */
    uint32_t write(size_t element, const float* numbers, uint32_t count) const {
        uint8_t* to = first + element * strideBytes;
        if (!half) {
            for (uint32_t k = 0; k < count; ++k) std::memcpy(to + 4 * k, numbers + k, 4);  // not one call of memcpy for so few bytes
            return 0;
        }
        uint32_t saturated = 0;
        for (uint32_t k = 0; k < count; ++k) {
            saturated += std::abs(numbers[k]) > kMaxHalf;
            const uint16_t half = halfFromFloat(std::clamp(numbers[k], -kMaxHalf, kMaxHalf));
            std::memcpy(to + 2 * k, &half, sizeof half);
        }
        return saturated;
    }
};

}  // namespace dpl
