// SPDX-License-Identifier: Apache-2.0
// Content hash of an avatar file: XXH3-64 of the JSON, with its own 16 hex digits read as zeros, and the binary chunk. Internal.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace dpl {

/** Text before the 16 digits. Quotes inside other strings are escaped, so the text occurs once. */
constexpr std::string_view kHashKey = "\"contentHash\":\"xxh3:";
constexpr size_t kHashDigits = 16;

/** Offset of the digits in `json`; npos if they are missing, malformed or occur twice. */
size_t findHashDigits(std::string_view json);
/** The hash in 16 lower-case hex digits. digitsAt: from findHashDigits. */
std::string contentHash(std::string_view json, size_t digitsAt, std::span<const uint8_t> bin);

}  // namespace dpl
