// SPDX-License-Identifier: Apache-2.0
// Counter-based random numbers: a value depends only on seed, stream and index, not on the thread.
#pragma once

#include <cmath>
#include <cstdint>

namespace dpl {

inline uint64_t mixBits(uint64_t x) {  // splitmix64's finaliser
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

class Random {
public:
    explicit Random(uint64_t seed, uint64_t stream = 0) : state_(mixBits(seed ^ mixBits(stream))) {}
    uint64_t bits() { return mixBits(state_++); }
    double uniform() { return double(bits() >> 11) * 0x1p-53; }
    double uniform(double low, double high) { return low + (high - low) * uniform(); }
    uint32_t below(uint32_t count) { return uint32_t((bits() >> 32) * count >> 32); }
    double normal() {
        const double u = 1 - uniform(), v = uniform();
        return std::sqrt(-2 * std::log(u)) * std::cos(6.283185307179586 * v);
    }

private:
    uint64_t state_;
};

}  // namespace dpl
