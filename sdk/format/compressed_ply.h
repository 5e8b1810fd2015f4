// SPDX-License-Identifier: Apache-2.0
// Reads PlayCanvas / SuperSplat compressed PLY: general splats of 16 bytes in chunks of 256 with common value ranges, and SH as bytes.
#pragma once

#include <cstdint>
#include <span>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/splat_remarks.h"

namespace dpl {

/** Reads elements `chunk` (12 or 18 floats), `vertex` (four packed words) and `sh` (9, 24, 45 or 72 bytes, may be absent), in any column
 *  order and in the coordinates of the file. Comments set `compensated` and the axes in `remarks`. Splats that are not finite are left out.
 *  CorruptData, Unsupported: the text names what is missing, truncated or of another type. Any thread. */
Result<StaticSplatData> readCompressedPly(std::span<const uint8_t> bytes, SplatRemarks* remarks = nullptr);

}  // namespace dpl
