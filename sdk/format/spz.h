// SPDX-License-Identifier: Apache-2.0
// General splats as SPZ, versions 2, 3 (one gzip stream) and 4 (a zstd stream an attribute).
#pragma once

#include <cstdint>
#include <span>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

constexpr uint32_t kMinSpzVersion = 2, kMaxSpzVersion = 4;
constexpr uint64_t kMaxSpzExpansion = 256;  // files that claim to unpack to more than this times their size (and 1 MiB) are refused

/** What the header says. */
struct SpzInfo {
    uint32_t version = 0;
    uint32_t splats = 0;
    uint32_t shDegree = 0;  // of the file, 0..4
};

/** Coordinates stay as they are in the file, which by its definition is x right, y up, z back: ours. Bands above SH degree 3 are dropped
 *  with a log line, extensions are skipped. `compensated` is set when the file says that it was trained antialiased.
 *  Version: one that this build does not read. CorruptData: damaged, truncated, or a claim above kMaxSpzExpansion. Any thread. */
Result<StaticSplatData> readSpz(std::span<const uint8_t> bytes, SpzInfo* info = nullptr);

}  // namespace dpl
