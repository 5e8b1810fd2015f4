// SPDX-License-Identifier: Apache-2.0
// General splats as a glTF 2.0 binary with KHR_gaussian_splatting: written, so that other viewers can show a posed frame, and read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/read_limits.h"

namespace dpl {

/** One POINTS primitive: POSITION, COLOR_0 (a plain fallback for viewers without the extension) and the extension's ROTATION (xyzw),
 *  SCALE (linear standard deviations, as ratified; drafts had logarithms), OPACITY and SH_DEGREE_l_COEF_n, all float. InvalidArgument when
 * array lengths differ or a number is not finite. */
Result<std::vector<uint8_t>> writeGltfSplats(const StaticSplatData& splats);

/** All splat primitives of all nodes as one set in world space, SH turned along; primitives of other kinds are skipped. A primitive with
 * fewer SH bands than another is filled up with zeros. Attribute types as the extension lists them, integers included. Unsupported, with
 * what would help: a kernel, projection, colour space or compression other than the ratified base (ellipse, perspective,
 *  srgb_rec709_display), nodes that scale their axes differently, files without splats. CorruptData: damaged or hostile bytes; no byte of
 * the file is decoded more than about once, so mesh instances are refused. Any thread. */
Result<StaticSplatData> readGltfSplats(std::span<const uint8_t> bytes, const ReadLimits& limits = {});

}  // namespace dpl
