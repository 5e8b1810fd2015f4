// SPDX-License-Identifier: Apache-2.0
// Converts vectors of trivially copyable values to bytes and back.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace dpl {

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
