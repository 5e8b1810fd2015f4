// SPDX-License-Identifier: Apache-2.0
// How every table of the page begins and ends: in a box of its own, which scrolls where the screen is narrower than the table.
#pragma once

namespace dpl {

inline constexpr const char* kTableBegin = "<div class=scroll><table>";
inline constexpr const char* kTableEnd = "</table></div>";

}  // namespace dpl
