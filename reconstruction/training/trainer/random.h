// SPDX-License-Identifier: Apache-2.0
// Counter-based random numbers. A value is a function of (seed, stream, index), so a checkpoint stores no generator state.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

namespace dpl {

/** SplitMix64 finaliser over the three numbers. */
inline uint64_t hashBits(uint64_t seed, uint64_t stream, uint64_t index) {
    uint64_t x =
        seed * 0x9E3779B97F4A7C15ull ^ (stream + 0x632BE59BD9B4E019ull) * 0xD1B54A32D192ED03ull ^ (index + 1) * 0xBF58476D1CE4E5B9ull;
    for (int round = 0; round < 2; ++round) {
        x ^= x >> 30, x *= 0xBF58476D1CE4E5B9ull;
        x ^= x >> 27, x *= 0x94D049BB133111EBull;
        x ^= x >> 31;
    }
    return x;
}

/** Uniform in [0, 1). */
inline double hashUniform(uint64_t seed, uint64_t stream, uint64_t index) {
    return double(hashBits(seed, stream, index) >> 11) * 0x1.0p-53;
}

/** Two independent standard normal numbers (Box–Muller). */
inline std::pair<double, double> hashNormals(uint64_t seed, uint64_t stream, uint64_t index) {
    const double u = 1 - hashUniform(seed, stream, 2 * index), v = hashUniform(seed, stream, 2 * index + 1);
    const double radius = std::sqrt(-2 * std::log(u));
    return {radius * std::cos(6.283185307179586 * v), radius * std::sin(6.283185307179586 * v)};
}

}  // namespace dpl
