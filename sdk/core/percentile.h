// SPDX-License-Identifier: Apache-2.0
// One definition of a percentile for everything that reports one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dpl {

/** The value that `share` of the values lie below (of n sorted ones number ⌊share·n⌋, the last for a share of 1); 0 when there are none.
 *  share in [0, 1]. */
template <class T>
T percentile(std::vector<T> values, double share) {
    if (values.empty()) return T{};
    const auto at = values.begin() + std::ptrdiff_t(std::min(values.size() - 1, std::size_t(share * double(values.size()))));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

}  // namespace dpl
