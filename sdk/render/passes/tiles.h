// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** Weakest low-pass that the tile kernel can draw. The kernel computes α at the end of a tile's column that is nearer to the peak, and
 *  multiplies by factors from there (fill.comp). With conic C ≤ 1/κ, at most 3.5 px to the peak and α ≥ 1/255 there, −ln α at that end
 *  is at most ½·3.5²/κ + ln 255 = 86, so that a float can hold α. With a weaker low-pass α would underflow, although a neighbouring
 *  pixel still shows the splat. With four samples C is up to four times larger and the peak at most 1.5 px away: 65. Trained avatars
 *  have κ = 1/12. */
constexpr float kTileMinKappaPx2 = 0.076f;

/** Sizes of the lists of compute tiles, known before the first frame. Rows of tiles are counted over all views. */
struct TilePlan {
    gpu::TilePush push{};
    uint64_t tableWords = 0, sumWords = 0, spanBytes = 0, entryBytes = 0, pixelBytes = 0;
    uint32_t rows() const { return push.viewCount * push.rows; }
};

/** Empty when the tables for this many splats and pixels do not fit the device. If a list overflows in a frame, the tiles of that frame
 *  search for their splats. */
std::optional<TilePlan> planTiles(const FrameIds& ids, const DeviceInfo& device);

/** Names of the kernels that fill such frames with this many samples a pixel: from lists, and without them. */
struct TileKernels {
    std::string fill, search;
};
TileKernels tileKernelsOf(const FrameIds& ids, uint32_t samples);

/** Builds the list of each tile from the sorted survivors, nearest first, and draws the lists into ids.tilePixels: RGBA8 of all views,
 *  then the depth sums. The frame needs no target, even if a list was too small. */
void addTiles(FramePlan& plan, const FrameIds& ids, const TilePlan& tiles);

}  // namespace dpl
