// SPDX-License-Identifier: Apache-2.0
// Writes and reads general splats as a glTF 2.0 binary with KHR_gaussian_splatting. Written files show a posed frame in other viewers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/read_limits.h"
#include "sdk/format/splat_remarks.h"

namespace dpl {

/** Writes one POINTS primitive with POSITION, COLOR_0 (for viewers without the extension) and the extension's attributes ROTATION (xyzw),
 *  SCALE (linear standard deviations, as ratified; drafts had logarithms), OPACITY and SH_DEGREE_l_COEF_n, all float. InvalidArgument if
 *  array lengths differ or a number is not finite. */
Result<std::vector<uint8_t>> writeGltfSplats(const StaticSplatData& splats);

/** Reads the splat primitives of all nodes as one set in world space, with rotated SH; other primitives are skipped. Missing SH bands of a
 *  primitive become zeros. All attribute types of the extension are read, also integers. Splats that are not finite are left out. Any
 *  thread.
 *  Unsupported (the text says what would help): a kernel, projection, colour space or compression other than the ratified base (ellipse,
 *  perspective, srgb_rec709_display); a node with different scales of its axes; a file without splats.
 *  CorruptData: damaged or hostile bytes. Each byte may be decoded about once, so instances of a mesh are refused. */
Result<StaticSplatData> readGltfSplats(std::span<const uint8_t> bytes, const ReadLimits& limits = {}, SplatRemarks* remarks = nullptr);

}  // namespace dpl
