// SPDX-License-Identifier: Apache-2.0
// Reads general splats from SPZ, versions 2 and 3 (one gzip stream) and 4 (a zstd stream per attribute), and writes 3 and 4.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/splat_remarks.h"

namespace dpl {

constexpr uint32_t kMinSpzVersion = 2, kMaxSpzVersion = 4;
constexpr uint64_t kMaxSpzExpansion = 256;  // a file may unpack to at most this × its size, and always to 1 MiB

/** Values of the header. */
struct SpzInfo {
    uint32_t version = 0;
    uint32_t splats = 0;
    uint32_t shDegree = 0;  // of the file, 0..4
    SplatRemarks remarks;
};

/** Keeps the coordinates of the file: x right, y up, z back, as Doppel's, unless the extension for coordinate systems states others; see
 *  `remarks`. SH bands above degree 3 are dropped with a note; other extensions are skipped. Sets `compensated` if the file says that it
 *  was trained antialiased. Any thread.
 *  Version: a version that this build does not read. CorruptData: damaged or truncated, or it would unpack beyond kMaxSpzExpansion. */
Result<StaticSplatData> readSpz(std::span<const uint8_t> bytes, SpzInfo* info = nullptr);

/** Writes splats in our axes, which are SPZ's, without an extension. version: 3 (gzip, for older readers) or 4 (zstd). Positions take 24
 *  bits, of which 12 or, in small or large scenes, more or fewer follow the point; other numbers 8 bits (rotations 32). InvalidArgument:
 *  array lengths differ, a number is not finite, another version. Unsupported: coordinates beyond ±8,388,607 m. */
Result<std::vector<uint8_t>> writeSpz(const StaticSplatData& splats, uint32_t version = kMaxSpzVersion);

}  // namespace dpl
