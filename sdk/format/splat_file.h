// SPDX-License-Identifier: Apache-2.0
// Any file of general splats, told by its bytes: INRIA PLY, PlayCanvas compressed PLY, SPZ, glTF KHR_gaussian_splatting
// (docs/formats/splats.md).
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/read_limits.h"

namespace dpl {

enum class SplatFormat : uint8_t { None, InriaPly, CompressedPly, Spz, Gltf };

/** For people: "PLY", "compressed PLY" ... */
const char* nameOf(SplatFormat format);

/** By content, reading headers only. None: anything else, an avatar file too. A format does not promise that the file can be read. */
SplatFormat splatFormatOf(std::span<const uint8_t> bytes);

struct SplatFile {
    SplatFormat format = SplatFormat::None;
    uint32_t version = 0;   // of SPZ, else 0
    uint32_t shDegree = 0;  // in the file; splats.shDegree is what is drawn
    StaticSplatData splats;
};

/** Reads a file of any of these formats. Sizes are checked before anything is allocated: peak memory is at most 64 MiB + 1280 × the file
 * (SPZ may unpack to 256 × its size, see spz.h; the others take far less). Errors name what is wrong and what would help. Unsupported: none
 * of them. Any thread, no exception escapes. */
Result<SplatFile> readSplats(std::span<const uint8_t> bytes, const ReadLimits& limits = {});

/** Box of the middle 98 % of the centres along each axis, so that a few strays far off do not count. Zeros when there are none. */
struct SplatBox {
    Vec3f low{0}, high{0};
};
SplatBox boxOf(const StaticSplatData& splats);

}  // namespace dpl
