// SPDX-License-Identifier: Apache-2.0
// The first version of the fill by compute tiles. It runs after the plain frame's sort. Frozen (README.md).
#pragma once

#include "sdk/render/plan.h"
#include "tools/bench/baseline/shaders/shared/tiles.h"

namespace dpl::plain {

/** Layout and size of the tile lists of one eye. */
struct TilePlan {
    TilePush push{};
    uint64_t listWords = 0;
};

/** Returns Unsupported if the lists for this many splats and pixels do not fit the device. */
Result<TilePlan> planTiles(uint32_t splatCount, uint32_t widthPx, uint32_t heightPx, const DeviceInfo& device);

struct TileBuffers {
    BufferId counts, lists, entries, pixels;  // TileCounts; tables and spans; records by tile; RGBA8
};

/** Adds the passes from sorted survivors to pixels. If a list is too small, the pixels stay empty and TileCounts::overflowed is 1. */
void addTiles(FramePlan& plan, const TilePlan& tiles, uint32_t splatCount, BufferId pairs, BufferId projected, BufferId counts,
              const TileBuffers& to);

}  // namespace dpl::plain
