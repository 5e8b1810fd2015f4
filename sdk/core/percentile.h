// SPDX-License-Identifier: Apache-2.0
// The one definition of a percentile, for all reports.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dpl {

/** The value at index min(⌊share·n⌋, n − 1) of the n values in rising order, without interpolation. share: 0 to 1. 0 if there are no
 *  values. */
template <class T>
T percentile(std::vector<T> values, double share) {
    if (values.empty()) return T{};
    const auto at = values.begin() + std::ptrdiff_t(std::min(values.size() - 1, std::size_t(share * double(values.size()))));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

}  // namespace dpl
