// SPDX-License-Identifier: Apache-2.0
// Density control: split, clone and prune splats (docs/reference/losses.md). Moving frames add to the statistics only where no still
// frame is used.
#pragma once

#include <vector>

#include "reconstruction/training/trainer/adam.h"
#include "reconstruction/training/trainer/trainable.h"

namespace dpl {

struct DensityStatistics {
    std::vector<float> gradientSum;  // N: |∂loss/∂centre| per half picture height, summed over the frames that count
    std::vector<uint32_t> seen;      // N: those of them that showed the splat since the last event

    void resize(size_t count) { gradientSum.assign(count, 0.0f), seen.assign(count, 0); }
};

struct DensitySettings {
    uint64_t seed = 1;
    uint32_t maxSplats = 100000;
    uint32_t maxGrowth = 4000;  // new splats an event, at most
    float minOpacity = 0.005f;  // splats below are pruned, except the last one of a triangle
    float bigM = 0.008f;        // metres; splats larger than this and than 0.6·triangle size are split, others cloned
};

struct DensityReport {
    uint32_t split = 0, cloned = 0, pruned = 0;
};

/** One density event: prunes faint splats, and splits or clones those with the largest mean screen gradient, within the budget. Adam rows
 *  move with their splats; rows of new splats are zero. Splats stay sorted by triangle. The statistics are reset. `event` is the event's
 *  number, which selects its random numbers. */
DensityReport densify(TrainableSplats& splats, AdamRows& adam, DensityStatistics& statistics, std::span<const RestTriangle<float>> rest,
                      std::span<const float> triangleSizeM, const DensitySettings& settings, uint64_t event);

}  // namespace dpl
