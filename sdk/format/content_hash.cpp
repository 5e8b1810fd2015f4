// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/content_hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace dpl {

size_t findHashDigits(std::string_view json) {
    const size_t key = json.find(kHashKey);
    if (key == std::string_view::npos || json.find(kHashKey, key + 1) != std::string_view::npos) return std::string_view::npos;
    const size_t at = key + kHashKey.size();
    if (json.size() < at + kHashDigits + 1 || json[at + kHashDigits] != '"') return std::string_view::npos;
    for (char c : json.substr(at, kHashDigits))
        if (!((c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'))) return std::string_view::npos;
    return at;
}

std::string contentHash(std::string_view json, size_t digitsAt, std::span<const uint8_t> bin) {
    XXH3_state_t state;
    XXH3_64bits_reset(&state);
    XXH3_64bits_update(&state, json.data(), digitsAt);
    XXH3_64bits_update(&state, "0000000000000000", kHashDigits);
    XXH3_64bits_update(&state, json.data() + digitsAt + kHashDigits, json.size() - digitsAt - kHashDigits);
    XXH3_64bits_update(&state, bin.data(), bin.size());
    uint64_t digest = XXH3_64bits_digest(&state);
    std::string text(kHashDigits, '0');
    for (size_t i = kHashDigits; i-- > 0; digest >>= 4) text[i] = "0123456789abcdef"[digest & 15];
    return text;
}

}  // namespace dpl
