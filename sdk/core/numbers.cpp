// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/numbers.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace dpl {
namespace {

// The longest decimal that a double needs, the exact value of the smallest ones, has 1077 characters.
constexpr size_t kMaxCharacters = 2000;
constexpr size_t kMaxExponentCharacters = 12;  // 'e', a sign, ten digits

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

}  // namespace

// libc++ before version 20 has no std::from_chars for floating types, and std::strtod expects the decimal point of the process's locale.
// So strtod gets the number without a point: "-12.5e3" becomes "-125e2", which means the same in every locale.
bool readNumber(std::string_view text, double& value) {
    if (text.size() > kMaxCharacters) return false;
    char plain[kMaxCharacters + kMaxExponentCharacters + 1];
    char* to = plain;
    const char *at = text.data(), *const end = at + text.size();
    bool zero = true;
    const auto copyDigits = [&] {
        const char* const first = at;
        for (; at != end && isDigit(*at); ++at) zero = zero && *at == '0', *to++ = *at;
        return int32_t(at - first);
    };
    if (at != end && *at == '-') *to++ = *at++;
    int32_t digits = copyDigits(), fraction = 0;
    if (at != end && *at == '.') {
        ++at;
        fraction = copyDigits();
    }
    if (digits + fraction == 0) return false;
    int64_t exponent = -fraction;
    if (at != end && (*at == 'e' || *at == 'E')) {
        ++at;
        if (end - at > 1 && *at == '+' && isDigit(at[1])) ++at;
        int32_t written = 0;
        if (!readNumber(std::string_view(at, size_t(end - at)), written)) return false;
        exponent += written;
        at = end;
    }
    if (at != end) return false;
    if (exponent != 0) {
        *to++ = 'e';
        to = std::to_chars(to, plain + sizeof plain - 1, exponent).ptr;
    }
    *to = 0;
    const double read = std::strtod(plain, nullptr);
    if (!std::isfinite(read) || (read == 0 && !zero)) return false;
    value = read;
    return true;
}

bool readNumber(std::string_view text, float& value) {
    double read = 0;
    if (!readNumber(text, read)) return false;
    const float rounded = float(read);
    if (!std::isfinite(rounded) || (rounded == 0 && read != 0)) return false;
    value = rounded;
    return true;
}

}  // namespace dpl
