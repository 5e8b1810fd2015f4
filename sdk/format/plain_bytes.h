// SPDX-License-Identifier: Apache-2.0
// Plain bytes: how they begin, and vectors of trivially copyable values to bytes and back.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace dpl {

inline bool beginsWith(std::span<const uint8_t> bytes, std::string_view magic) {
    return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

template <class T>
std::vector<uint8_t> bytesOf(const std::vector<T>& values) {
    const auto* raw = reinterpret_cast<const uint8_t*>(values.data());
    return {raw, raw + values.size() * sizeof(T)};
}

/** bytes.size() must be a multiple of sizeof(T). */
template <class T>
void fill(std::vector<T>& values, std::span<const uint8_t> bytes) {
    values.resize(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
}

}  // namespace dpl
