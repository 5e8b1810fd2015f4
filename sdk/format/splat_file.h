// SPDX-License-Identifier: Apache-2.0
// Recognises and reads any file of general splats: INRIA PLY, PlayCanvas compressed PLY, SPZ, glTF KHR_gaussian_splatting
// (docs/formats/splats.md).
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/read_limits.h"
#include "sdk/format/splat_remarks.h"

namespace dpl {

enum class SplatFormat : uint8_t { None, InriaPly, CompressedPly, Spz, Gltf };

/** Name for people: "PLY", "compressed PLY" ... */
const char* nameOf(SplatFormat format);

/** Recognises the format by the headers. None: anything else, also an avatar file. The file may still be damaged. */
SplatFormat splatFormatOf(std::span<const uint8_t> bytes);
/** Whether it is one of the formats. */
bool isSplatFile(std::span<const uint8_t> bytes);

struct SplatFile {
    SplatFormat format = SplatFormat::None;
    uint32_t version = 0;  // of an SPZ file, else 0
    StaticSplatData splats;
    SplatRemarks remarks;  // what the file states, and what was left out
};

/** Reads a file of any of these formats, and turns the splats into our axes where the file or its format states others. Checks sizes before
 * it allocates: peak memory is at most 64 MiB + 1280 × the file. (SPZ may unpack to 256 × its size, see spz.h; the others take far less.)
 * Errors say what is wrong and what would help. Unsupported: another format. Any thread; throws nothing. */
Result<SplatFile> readSplats(std::span<const uint8_t> bytes, const ReadLimits& limits = {});

/** Bounding box of the middle 98 % of the centres along each axis, so that a few distant splats do not count. Where the splats
 *  are larger than that, as for a single one, the box reaches three standard deviations from its middle. Zeros without splats. */
struct SplatBox {
    Vec3f low{0}, high{0};
};
SplatBox boxOf(const StaticSplatData& splats);

}  // namespace dpl
