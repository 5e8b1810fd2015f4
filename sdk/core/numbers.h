// SPDX-License-Identifier: Apache-2.0
// Numbers in texts.
#pragma once

#include <charconv>
#include <concepts>
#include <string_view>

namespace dpl {

/** Reads a number that fills the whole of `text`: an optional '-', digits with or without a point, and an optional exponent. Returns false
 *  for everything else: spaces, a leading '+', hexadecimal, "inf" and "nan", and what `value` cannot hold (too large, or so small that
 *  only zero is left; a text of more than 2000 characters). The process's locale does not matter. Allocates nothing. Any thread. `value` is
 *  written only on success. */
bool readNumber(std::string_view text, double& value);
bool readNumber(std::string_view text, float& value);

/** The same for whole numbers. Unsigned types refuse a '-'. */
template <std::integral Integer>
bool readNumber(std::string_view text, Integer& value) {
    Integer read{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), read);
    if (error != std::errc() || end != text.data() + text.size()) return false;
    value = read;
    return true;
}

}  // namespace dpl
