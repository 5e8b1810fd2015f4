// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/page/html_text.h"

namespace dpl {

std::string escapeHtml(std::string_view text) {
    std::string out;
    for (char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

std::string base64(std::span<const uint8_t> bytes) {
    static constexpr char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    out.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t word = uint32_t(bytes[i]) << 16;
        if (i + 1 < bytes.size()) word |= uint32_t(bytes[i + 1]) << 8;
        if (i + 2 < bytes.size()) word |= bytes[i + 2];
        out += kAlphabet[word >> 18];
        out += kAlphabet[word >> 12 & 63];
        out += i + 1 < bytes.size() ? kAlphabet[word >> 6 & 63] : '=';
        out += i + 2 < bytes.size() ? kAlphabet[word & 63] : '=';
    }
    return out;
}

}  // namespace dpl
