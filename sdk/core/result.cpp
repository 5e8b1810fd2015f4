// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/result.h"

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace dpl {

void TextValue::appendTo(std::string& out) const {
    char number[32];
    const auto whole = [&](auto value) { out.append(number, std::to_chars(number, number + sizeof number, value).ptr); };
    switch (kind_) {
        case Kind::Text:
            out += text_;
            break;
        case Kind::Character:
            out += character_;
            break;
        case Kind::Unsigned:
            whole(unsigned_);
            break;
        case Kind::Signed:
            whole(signed_);
            break;
        case Kind::Floating: {
            const int length = std::snprintf(number, sizeof number, "%g", floating_);
            std::replace(number, number + length, ',', '.');  // of the process's locale
            out.append(number, size_t(length));
        }
    }
}

std::string formatValues(std::string_view text, std::span<const TextValue> values) {
    std::string out;
    for (const TextValue& value : values) {
        const size_t hole = text.find("{}");
        if (hole == std::string_view::npos) break;
        out += text.substr(0, hole);
        value.appendTo(out);
        text.remove_prefix(hole + 2);
    }
    return out += text;
}

}  // namespace dpl
