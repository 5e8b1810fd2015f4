// SPDX-License-Identifier: Apache-2.0
// The splats of an avatar that a level of detail keeps, as a list.
#pragma once

#include <span>
#include <vector>

#include "sdk/format/coded_splats.h"
#include "sdk/math/detail.h"

namespace dpl {

struct KeptSplat {
    uint32_t splat, chunk;  // chunk: that holds it
    float weight, growth;   // factors of the opacity and of the standard deviations
};

/** Appends the splats that a level of detail keeps, in rising order. detail: not full(). groups: two per chunk (measureDetail). */
void keepSplats(std::span<const SplatChunk> chunks, std::span<const SplatGroup> groups, const SplatDetail& detail,
                std::vector<KeptSplat>& out);

}  // namespace dpl
