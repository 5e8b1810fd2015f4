// General splats as a glTF 2.0 binary with KHR_gaussian_splatting, so that other viewers can show a posed frame.
#pragma once

#include <cstdint>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** One POINTS primitive: POSITION, COLOR_0 (a plain fallback for viewers without the extension) and the extension's ROTATION (xyzw),
 *  SCALE (linear standard deviations, as ratified; drafts had logarithms), OPACITY and SH_DEGREE_l_COEF_n, all float. InvalidArgument when array lengths differ or a
 *  number is not finite. */
Result<std::vector<uint8_t>> writeGltfSplats(const StaticSplatData& splats);

}  // namespace dpl
