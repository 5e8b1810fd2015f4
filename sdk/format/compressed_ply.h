// SPDX-License-Identifier: Apache-2.0
// Reads PlayCanvas / SuperSplat compressed PLY: general splats of 16 bytes in chunks of 256 with common value ranges, and SH as bytes.
#pragma once

#include <cstdint>
#include <span>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Reads elements `chunk` (12 or 18 floats), `vertex` (four packed words) and `sh` (9, 24 or 45 bytes, may be absent), in any column order.
 *  CorruptData names what is missing, truncated or not finite, and in which chunk. Any thread. */
Result<StaticSplatData> readCompressedPly(std::span<const uint8_t> bytes);

}  // namespace dpl
