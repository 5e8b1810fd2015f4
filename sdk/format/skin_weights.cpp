// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/skin_weights.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace dpl {

PackedWeights packWeights(std::span<const std::pair<uint32_t, float>> jointAndWeight) {
    std::vector<std::pair<uint32_t, double>> merged;
    for (const auto& [joint, weight] : jointAndWeight) {
        if (!std::isfinite(weight) || !(weight > 0)) continue;
        auto same = std::find_if(merged.begin(), merged.end(), [&, j = joint](const auto& entry) { return entry.first == j; });
        if (same != merged.end())
            same->second += weight;
        else
            merged.emplace_back(joint, weight);
    }
    PackedWeights packed;
    packed.weights[0] = 255;
    if (merged.empty()) return packed;
    std::sort(merged.begin(), merged.end(),
              [](const auto& a, const auto& b) { return a.second != b.second ? a.second > b.second : a.first < b.first; });
    if (merged.size() > 4) merged.resize(4);
    double sum = 0;
    for (const auto& entry : merged) sum += entry.second;
    // Largest remainder. The list is sorted by weight, so of equal remainders the larger weight wins.
    int given = 0;
    double remainder[4] = {-1, -1, -1, -1};
    int units[4] = {0, 0, 0, 0};
    for (size_t k = 0; k < merged.size(); ++k) {
        const double exact = 255 * merged[k].second / sum;
        units[k] = int(exact), remainder[k] = exact - units[k], given += units[k];
    }
    for (; given < 255; ++given) {
        const size_t k = size_t(std::max_element(remainder, remainder + merged.size()) - remainder);
        ++units[k], remainder[k] = -1;
    }
    packed.weights[0] = 0;
    for (size_t k = 0; k < merged.size(); ++k)
        if (units[k]) packed.joints[int(k)] = uint16_t(merged[k].first), packed.weights[int(k)] = uint8_t(units[k]);
    return packed;
}

PackedWeights cutToFour(std::span<const float> row, std::span<const uint32_t> jointOf) {
    float fifth = 0;
    if (row.size() > 4) {
        std::vector<float> sorted(row.begin(), row.end());
        std::nth_element(sorted.begin(), sorted.begin() + 4, sorted.end(), std::greater<>());
        fifth = sorted[4];
    }
    std::vector<std::pair<uint32_t, float>> kept;
    for (size_t c = 0; c < row.size(); ++c)
        if (row[c] > fifth) kept.emplace_back(jointOf[c], row[c] - fifth);
    return packWeights(kept);
}

}  // namespace dpl
