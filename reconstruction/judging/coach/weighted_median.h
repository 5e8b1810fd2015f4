// SPDX-License-Identifier: Apache-2.0
// Medians by area. Private to reconstruction/judging/coach.
#pragma once

#include <algorithm>
#include <vector>

namespace dpl {

struct WeightedValue {
    double value, weight;
};

/** The value at half of the weight; 0 without values. */
inline double weightedMedian(std::vector<WeightedValue> values) {
    double sum = 0, half = 0;
    for (const WeightedValue& v : values) sum += v.weight;
    std::sort(values.begin(), values.end(), [](const WeightedValue& a, const WeightedValue& b) { return a.value < b.value; });
    for (const WeightedValue& v : values)
        if ((half += v.weight) >= sum / 2) return v.value;
    return 0;
}

}  // namespace dpl
