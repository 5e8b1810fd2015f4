// SPDX-License-Identifier: Apache-2.0
// The capture map as data: checks, and its stream in a file, encoding 1 (docs/formats/avatar.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Sizes that a file can hold; encodeCaptureMap() moves others to the nearer end. */
constexpr float kLeastCaptureM = 1e-4f, kMostCaptureM = 6;

/** Refuses a map that has not 4 sides a joint, sizes that are negative or not finite, a detail finer than its pixel, and views of a side
 *  that is not seen (InvalidArgument, naming joint and side). An empty map passes. */
Status checkCaptureMap(const CaptureMapData& map, size_t jointCount);

/** 12 bytes a joint: of each side the code of pixelM, the code of detailM, and the number of views, at most 255. A code c > 0 is
 *  0.1 mm · 2^((c−1)/16); 0: not seen. Sizes are rounded by up to 2.2 %. The map must have passed checkCaptureMap(). */
std::vector<uint8_t> encodeCaptureMap(const CaptureMapData& map);

/** The caller checks the values by checkCaptureMap(). CorruptData: not 12 bytes a joint. */
Result<CaptureMapData> decodeCaptureMap(std::span<const uint8_t> bytes, size_t jointCount);

}  // namespace dpl
