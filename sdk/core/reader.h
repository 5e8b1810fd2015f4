// SPDX-License-Identifier: Apache-2.0
// Reads little-endian bytes and checks every size against the bytes left before it uses it.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "sdk/core/result.h"

namespace dpl {

static_assert(std::endian::native == std::endian::little, "Doppel reads and writes little-endian files in place");

class Reader {
public:
    explicit Reader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

    size_t position() const { return position_; }
    size_t remaining() const { return bytes_.size() - position_; }

    Result<std::span<const uint8_t>> take(size_t byteCount) {
        if (byteCount > remaining())
            return fail(Code::CorruptData, "{} bytes wanted at offset {}, {} left", byteCount, position_, remaining());
        auto taken = bytes_.subspan(position_, byteCount);
        position_ += byteCount;
        return taken;
    }

    template <class T>
    requires std::is_trivially_copyable_v<T> Result<T> value() {
        DPL_TRY(auto raw, take(sizeof(T)));
        T result;
        std::memcpy(&result, raw.data(), sizeof(T));
        return result;
    }
    Result<uint32_t> u32() { return value<uint32_t>(); }
    Result<float> f32() { return value<float>(); }

    Status skip(size_t byteCount) {
        DPL_TRY([[maybe_unused]] auto skipped, take(byteCount));
        return {};
    }

private:
    std::span<const uint8_t> bytes_;
    size_t position_ = 0;
};

}  // namespace dpl
