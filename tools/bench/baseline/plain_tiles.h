// SPDX-License-Identifier: Apache-2.0
// The first way to fill pixels by compute tiles, behind the plain frame's sort. Frozen (README.md).
#pragma once

#include "sdk/render/plan.h"
#include "tools/bench/baseline/shaders/shared/tiles.h"

namespace dpl::plain {

/** What the lists of one eye take. */
struct TilePlan {
    TilePush push{};
    uint64_t listWords = 0;
};

/** Unsupported: the lists of this many splats and pixels do not fit the device. */
Result<TilePlan> planTiles(uint32_t splatCount, uint32_t widthPx, uint32_t heightPx, const DeviceInfo& device);

struct TileBuffers {
    BufferId counts, lists, entries, pixels;  // TileCounts; tables and spans; records by tile; RGBA8
};

/** Sorted survivors to pixels. A list that is too small leaves the pixels empty and TileCounts::overflowed at 1. */
void addTiles(FramePlan& plan, const TilePlan& tiles, uint32_t splatCount, BufferId pairs, BufferId projected, BufferId counts,
              const TileBuffers& to);

}  // namespace dpl::plain
