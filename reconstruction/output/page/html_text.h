// SPDX-License-Identifier: Apache-2.0
// Text and bytes inside HTML.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace dpl {

/** Escapes &, <, >, " for HTML text and attributes. */
std::string escapeHtml(std::string_view text);

/** Bytes in base64, with padding and without line breaks. */
std::string base64(std::span<const uint8_t> bytes);

}  // namespace dpl
