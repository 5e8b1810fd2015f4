// SPDX-License-Identifier: Apache-2.0
// PNG bytes for pictures that people look at.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"

namespace dpl {

/** 8-bit pixels, rows tight, top row first; channels 1 (grey), 3 (RGB) or 4 (RGBA, straight alpha). */
Result<std::vector<uint8_t>> encodePng(std::span<const uint8_t> pixels, uint32_t widthPx, uint32_t heightPx, uint32_t channels);

}  // namespace dpl
