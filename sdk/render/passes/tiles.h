#pragma once

#include <optional>

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** A column of a tile takes α from its fifth pixel by factors (fill.comp). With conic C ≤ 1/κ and α ≥ 1/255 within √(11.1/C) px of the peak, the exponent there is at most
 *  ½ (√11.1 + 4 √C)² = 75, well within a float; with a weaker low-pass it might underflow where a neighbour still shows. */
constexpr float kTileMinKappaPx2 = 0.2f;

/** What the lists of compute tiles take, all of it before the first frame. Rows of tiles are counted over all views. */
struct TilePlan {
    gpu::TilePush push{};
    uint64_t tableWords = 0, sumWords = 0, spanBytes = 0, entryBytes = 0, pixelBytes = 0;
    uint32_t rows() const { return push.viewCount * push.rows; }
};

/** None when the tables of this many splats and pixels do not fit the device. Lists that turn out too small in a frame leave that frame to the quads. */
std::optional<TilePlan> planTiles(const FrameIds& ids, const DeviceInfo& device);

/** Sorted survivors to the tiles' lists, near first in each, and these to ids.tilePixels: RGBA8 of all views, then the depth sums. Sets the draw's arguments to
 *  nothing unless a list was too small: then the pixels are in the target. */
void addTiles(FramePlan& plan, const FrameIds& ids, const TilePlan& tiles);

}  // namespace dpl
