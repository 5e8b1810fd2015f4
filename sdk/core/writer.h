// SPDX-License-Identifier: Apache-2.0
// Appends little-endian values to a growing buffer.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace dpl {

class Writer {
public:
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void value(const T& v) { append({reinterpret_cast<const uint8_t*>(&v), sizeof(T)}); }
    void append(std::span<const uint8_t> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
    void alignTo(size_t alignment, uint8_t fill = 0) {
        while (bytes_.size() % alignment) bytes_.push_back(fill);
    }
    size_t size() const { return bytes_.size(); }
    std::vector<uint8_t> finish() { return std::move(bytes_); }

private:
    std::vector<uint8_t> bytes_;
};

}  // namespace dpl
