// SPDX-License-Identifier: Apache-2.0
// Vectors of trivially copyable values in Doppel's own binary files: a 64-bit count, then the values.
#pragma once

#include <vector>

#include "sdk/core/reader.h"
#include "sdk/core/writer.h"

namespace dpl {

template <class T>
void putArray(Writer& out, const std::vector<T>& values) {
    out.value(uint64_t(values.size()));
    out.append({reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(T)});
}

/** Before it allocates, it refuses a count that the rest of the file cannot hold (CorruptData). */
template <class T>
Status getArray(Reader& in, std::vector<T>& values) {
    DPL_TRY(const uint64_t count, in.value<uint64_t>());
    if (count > in.remaining() / sizeof(T)) return fail(Code::CorruptData, "an array of {} entries does not fit into the file", count);
    DPL_TRY(auto bytes, in.take(size_t(count) * sizeof(T)));
    values.resize(size_t(count));
    if (count > 0) std::memcpy(static_cast<void*>(values.data()), bytes.data(), bytes.size());
    return {};
}

}  // namespace dpl
