// SPDX-License-Identifier: Apache-2.0
// Builds one line of a bench's JSON output: a flat object whose members keep the order in which they were added.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdio>
#include <string>
#include <string_view>

namespace dpl {

class JsonRow {
public:
    JsonRow& add(std::string_view name, std::string_view text) {
        begin(name) += '"';
        for (const char c : text) {
            if (c == '"' || c == '\\') line_ += '\\';
            line_ += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
        }
        line_ += '"';
        return *this;
    }
    JsonRow& add(std::string_view name, const char* text) { return add(name, std::string_view(text)); }
    JsonRow& add(std::string_view name, std::integral auto value) {
        begin(name) += std::to_string(value);
        return *this;
    }
    /** Writes six significant digits. Infinity and NaN, which JSON cannot represent, become null. */
    JsonRow& add(std::string_view name, double value) {
        char text[32];
        std::snprintf(text, sizeof text, "%.6g", value);
        begin(name) += std::isfinite(value) ? text : "null";
        return *this;
    }
    /** The object with a line break at its end. */
    std::string line() const { return "{" + line_ + "}\n"; }

private:
    std::string& begin(std::string_view name) {
        if (!line_.empty()) line_ += ',';
        line_ += '"';
        line_ += name;
        return line_ += "\":";
    }
    std::string line_;
};

}  // namespace dpl
