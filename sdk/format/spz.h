// SPDX-License-Identifier: Apache-2.0
// Reads general splats from SPZ, versions 2 and 3 (one gzip stream) and 4 (a zstd stream per attribute).
#pragma once

#include <cstdint>
#include <span>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

constexpr uint32_t kMinSpzVersion = 2, kMaxSpzVersion = 4;
constexpr uint64_t kMaxSpzExpansion = 256;  // a file may unpack to at most this × its size, and always to 1 MiB

/** Values of the header. */
struct SpzInfo {
    uint32_t version = 0;
    uint32_t splats = 0;
    uint32_t shDegree = 0;  // of the file, 0..4
};

/** Keeps the coordinates of the file; SPZ defines x right, y up, z back, as Doppel does. SH bands above degree 3 are dropped with a line in
 *  the log; extensions are skipped. Sets `compensated` if the file says that it was trained antialiased. Any thread.
 *  Version: a version that this build does not read. CorruptData: damaged or truncated, or it would unpack beyond kMaxSpzExpansion. */
Result<StaticSplatData> readSpz(std::span<const uint8_t> bytes, SpzInfo* info = nullptr);

}  // namespace dpl
