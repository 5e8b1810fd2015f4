// SPDX-License-Identifier: Apache-2.0
// What several parts of the page are made of. Private to reconstruction/judging/report.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "reconstruction/output/page/html_text.h"

namespace dpl {

/** How every table of the page begins and ends: in a box of its own, which scrolls where the screen is narrower than the table. */
inline constexpr const char* kTableBegin = "<div class=scroll><table>";
inline constexpr const char* kTableEnd = "</table></div>";

/** The page's style sheet. */
extern const char* const kPageStyle;

/** An image whose bytes are in the page; empty without bytes. `what`: its text, for whom it cannot be shown to; empty: those around it have
 * it. style: of the element. */
std::string pngImage(const std::vector<uint8_t>& png, const std::string& what);
std::string jpegImage(const std::vector<uint8_t>& jpeg, const std::string& what, const std::string& style = {});

/** A number with so many digits behind the point. */
std::string decimals(double value, int digits);

/** A list of sentences. */
std::string bulletList(const std::vector<std::string>& sentences);

}  // namespace dpl
