// SPDX-License-Identifier: Apache-2.0
// Density control: split, clone and prune (docs/reference/losses.md). Statistics come from static frames only.
#pragma once

#include <vector>

#include "reconstruction/splat/adam.h"
#include "reconstruction/splat/trainable.h"

namespace dpl {

struct DensityStatistics {
    std::vector<float> gradientSum;  // |∂loss/∂centre|, in units of half the picture's height, per splat
    std::vector<uint32_t> seen;      // number of static frames that saw it since the last event

    void resize(size_t count) { gradientSum.assign(count, 0.0f), seen.assign(count, 0); }
};

struct DensitySettings {
    uint64_t seed = 1;
    uint32_t maxSplats = 100000;
    uint32_t maxGrowth = 4000;  // new splats an event
    float minOpacity = 0.005f;  // pruned below, unless it is its triangle's last splat
    float bigM = 0.008f;        // split above this or above 0.6·triangle size, clone below
};

struct DensityReport {
    uint32_t split = 0, cloned = 0, pruned = 0;
};

/** One event: the splats with the largest mean screen gradient grow, within the budget. Adam rows follow their splats; new rows start
 *  at zero. Splats stay sorted by triangle; the statistics are reset. `event` numbers the events for the random stream. */
DensityReport densify(TrainableSplats& splats, AdamRows& adam, DensityStatistics& statistics, std::span<const RestTriangle<float>> rest,
                      std::span<const float> triangleSizeM, const DensitySettings& settings, uint64_t event);

}  // namespace dpl
