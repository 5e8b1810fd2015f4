// SPDX-License-Identifier: Apache-2.0
// The content hash of an avatar file: XXH3-64 of JSON (its own 16 hex digits read as zeros) and binary chunk. Internal.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace dpl {

/** Text in front of the 16 digits; quotes inside other strings are escaped, so it occurs once. */
constexpr std::string_view kHashKey = "\"contentHash\":\"xxh3:";
constexpr size_t kHashDigits = 16;

/** Offset of the digits in `json`, or npos when they are missing, malformed or there twice. */
size_t findHashDigits(std::string_view json);
/** Lower-case hex. `digitsAt` from findHashDigits. */
std::string contentHash(std::string_view json, size_t digitsAt, std::span<const uint8_t> bin);

}  // namespace dpl
