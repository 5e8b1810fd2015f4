// SPDX-License-Identifier: Apache-2.0
// A number at a place in bytes, in the machine's order.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

namespace dpl {

/** The caller has checked that the bytes reach so far. Any alignment. */
template <class T>
T valueAt(std::span<const uint8_t> bytes, size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof(T));
    return value;
}

}  // namespace dpl
