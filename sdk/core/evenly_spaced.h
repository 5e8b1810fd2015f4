// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

namespace dpl {

/** Up to `count` members, evenly spaced: the middles of `count` equal parts. */
template <class T>
std::vector<T> evenlySpaced(const std::vector<T>& all, size_t count) {
    std::vector<T> chosen;
    const size_t n = std::min(count, all.size());
    for (size_t i = 0; i < n; ++i) chosen.push_back(all[(2 * i + 1) * all.size() / (2 * n)]);
    return chosen;
}

}  // namespace dpl
