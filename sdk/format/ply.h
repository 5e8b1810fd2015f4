// SPDX-License-Identifier: Apache-2.0
// Reads and writes general splats as PLY in the layout of the first 3D Gaussian splatting release ("INRIA"): binary little-endian floats.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"
#include "sdk/format/splat_remarks.h"

namespace dpl {

struct PlyWriteOptions {
    bool normals = true;        // writes nx ny nz = 0, as the original tool does
    bool padToDegree3 = false;  // always 45 f_rest columns (62 floats per splat), for viewers that expect them
    std::string axes;           // letters of splat_axes.h: turns the splats to these axes and states them; empty: as they are, unstated
};

/** Reads x y z, f_dc_0..2, f_rest_*, opacity (logit), scale_0..2 (log), rot_0..3 (wxyz), in any column order, in the coordinates of the
 *  file. Without scale_2 the splats are flat (2D Gaussian splatting); filter_3D is fused into sizes and opacities; other scalar columns are
 *  skipped. Comments set `compensated` and the axes in `remarks`. Normalises rotations. Splats that are not finite are left out.
 *  CorruptData, Unsupported: the text names the column that is missing or of another type. */
Result<StaticSplatData> readPly(std::span<const uint8_t> bytes, SplatRemarks* remarks = nullptr);

/** Splats in our axes. InvalidArgument if array lengths differ or the axes are unknown. Opacities are clamped to [1e-6, 1−1e-6] before the
 *  logit. `compensated` is written as a comment. */
Result<std::vector<uint8_t>> writePly(const StaticSplatData& splats, const PlyWriteOptions& options = {});

}  // namespace dpl
