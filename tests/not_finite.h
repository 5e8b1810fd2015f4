// SPDX-License-Identifier: Apache-2.0
// Numbers that are not finite, for tests of hostile input.
#pragma once

#include <limits>

namespace dpl {

inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();

}  // namespace dpl
