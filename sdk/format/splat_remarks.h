// SPDX-License-Identifier: Apache-2.0
// What the readers of general splats found beside the splats, and the splats that they leave out.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sdk/core/result.h"
#include "sdk/format/splat_axes.h"

namespace dpl {

struct SplatRemarks {
    SplatAxes axes;
    uint32_t shDegree = 0;           // of the file; its splats have at most kMaxShDegree
    uint64_t dropped = 0;            // splats with numbers that are not finite, left out
    std::vector<std::string> notes;  // sentences for people: what was left out, fused or not understood
};

/** Leaves out the splats `broken` (rising indices), and counts and notes them. CorruptData if no splat is left. */
Status dropBroken(StaticSplatData& splats, std::span<const uint32_t> broken, SplatRemarks& remarks);

/** Notes bands above kMaxShDegree. */
void noteShDegree(SplatRemarks& remarks);

/** CorruptData if coordinates are so large that 32-bit floats are further apart than the splats are wide, as in a scene in map coordinates:
 *  its places are lost. A note if they are an eighth as far apart. */
Status checkPrecision(const StaticSplatData& splats, SplatRemarks& remarks);

}  // namespace dpl
