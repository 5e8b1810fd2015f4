// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/spatial_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dpl {
namespace {

constexpr uint32_t kCells = 1u << 21;
constexpr size_t kSamples = 4096;

/** Moves bit k to bit 3k, for 21 bits. */
uint64_t spreadBits(uint64_t v) {
    v = (v | v << 32) & 0x001F00000000FFFFull;
    v = (v | v << 16) & 0x001F0000FF0000FFull;
    v = (v | v << 8) & 0x100F00F00F00F00Full;
    v = (v | v << 4) & 0x10C30C30C30C30C3ull;
    return (v | v << 2) & 0x1249249249249249ull;
}

struct Range {
    float low = 0, high = 0;
};

/** Extent of most points along one axis: the middle 90 % of a sample, widened by a quarter at each end. */
Range rangeOf(std::span<const Vec3f> points, int axis) {
    std::vector<float> sample;
    for (size_t i = 0, step = points.size() / kSamples + 1; i < points.size(); i += step)
        if (std::isfinite(points[i][axis])) sample.push_back(points[i][axis]);
    if (sample.empty()) return {};
    std::sort(sample.begin(), sample.end());
    const float low = sample[sample.size() / 20], high = sample[sample.size() - 1 - sample.size() / 20];
    return {low - 0.25f * (high - low), high + 0.25f * (high - low)};
}

}  // namespace

std::vector<uint32_t> spatialOrder(std::span<const Vec3f> points) {
    std::vector<uint64_t> keys(points.size());
    Range ranges[3];
    float widest = 0;  // one scale for all axes, so that cells are cubes
    for (int axis = 0; axis < 3; ++axis)
        ranges[axis] = rangeOf(points, axis), widest = std::max(widest, ranges[axis].high - ranges[axis].low);
    const float scale = widest > 0 && std::isfinite(widest) ? float(kCells) / widest : 0;
    for (size_t i = 0; i < points.size(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            const float cell = (points[i][axis] - ranges[axis].low) * scale;
            keys[i] |= spreadBits(cell >= 1 ? uint64_t(std::min(cell, float(kCells - 1))) : 0) << axis;  // NaN: 0
        }
    }
    std::vector<uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
    return order;
}

}  // namespace dpl
