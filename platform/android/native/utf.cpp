// SPDX-License-Identifier: Apache-2.0
#include "platform/android/native/utf.h"

#include <cstdint>

namespace dpl::android {
namespace {

constexpr uint32_t kReplacement = 0xFFFD;

/** The code point at the start of `text`, and its length in bytes. What is no character has the length 1. */
struct Decoded {
    uint32_t point;
    size_t length;
};

Decoded decode(std::string_view text) {
    const auto byte = [&](size_t i) { return uint32_t(uint8_t(text[i])); };
    const uint32_t first = byte(0);
    if (first < 0x80) return {first, 1};
    const size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
    if (first < 0xC2 || first > 0xF4 || text.size() < length) return {kReplacement, 1};
    uint32_t point = first & (0x7Fu >> length);
    for (size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xC0) != 0x80) return {kReplacement, 1};
        point = point << 6 | (byte(i) & 0x3F);
    }
    constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = point >= 0xD800 && point <= 0xDFFF;
    if (point < kLeast[length] || point > 0x10FFFF || surrogate) return {kReplacement, 1};
    return {point, length};
}

}  // namespace

std::u16string utf16Of(std::string_view utf8) {
    std::u16string out;
    out.reserve(utf8.size());
    while (!utf8.empty()) {
        const Decoded next = decode(utf8);
        utf8.remove_prefix(next.length);
        if (next.point < 0x10000) {
            out.push_back(char16_t(next.point));
        } else {
            out.push_back(char16_t(0xD800 + ((next.point - 0x10000) >> 10)));
            out.push_back(char16_t(0xDC00 + ((next.point - 0x10000) & 0x3FF)));
        }
    }
    return out;
}

std::string utf8Of(std::u16string_view utf16) {
    std::string out;
    out.reserve(utf16.size());
    for (size_t i = 0; i < utf16.size(); ++i) {
        uint32_t point = utf16[i];
        const bool high = point >= 0xD800 && point <= 0xDBFF, low = point >= 0xDC00 && point <= 0xDFFF;
        if (high && i + 1 < utf16.size() && utf16[i + 1] >= 0xDC00 && utf16[i + 1] <= 0xDFFF)
            point = 0x10000 + ((point - 0xD800) << 10) + (utf16[++i] - 0xDC00);
        else if (high || low)
            point = kReplacement;
        const auto tail = [&](int shift) { out.push_back(char(0x80 | (point >> shift & 0x3F))); };
        if (point < 0x80) {
            out.push_back(char(point));
        } else if (point < 0x800) {
            out.push_back(char(0xC0 | point >> 6)), tail(0);
        } else if (point < 0x10000) {
            out.push_back(char(0xE0 | point >> 12)), tail(6), tail(0);
        } else {
            out.push_back(char(0xF0 | point >> 18)), tail(12), tail(6), tail(0);
        }
    }
    return out;
}

}  // namespace dpl::android
