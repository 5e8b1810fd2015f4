// SPDX-License-Identifier: Apache-2.0
// Reads and writes general splats as PLY in the layout of the first 3D Gaussian splatting release ("INRIA"): binary little-endian floats.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

struct PlyWriteOptions {
    bool normals = true;        // writes nx ny nz = 0, as the original tool does
    bool padToDegree3 = false;  // always 45 f_rest columns (62 floats per splat), for viewers that expect them
};

/** Reads x y z, f_dc_0..2, f_rest_* (0, 9, 24 or 45 columns), opacity (logit), scale_0..2 (log), rot_0..3 (wxyz), in any column order;
 *  other scalar columns are skipped. Normalises rotations. CorruptData names what is missing or not finite, and the vertex. */
Result<StaticSplatData> readPly(std::span<const uint8_t> bytes);

/** InvalidArgument if array lengths differ. Opacities are clamped to [1e-6, 1−1e-6] before the logit. */
Result<std::vector<uint8_t>> writePly(const StaticSplatData& splats, const PlyWriteOptions& options = {});

}  // namespace dpl
