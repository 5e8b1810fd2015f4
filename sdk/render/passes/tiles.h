// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "sdk/render/frame_ids.h"
#include "sdk/render/plan.h"

namespace dpl {

/** A column of a tile takes α from the end that lies nearer to its peak, by factors (fill.comp). With conic C ≤ 1/κ, 3.5 px to the peak at
 * most and α ≥ 1/255 there, the exponent at that end is at most ½ 3.5²/κ + ln 255 = 86, what a float holds; with a weaker low-pass it would
 * underflow where a neighbour still shows. With four samples C is up to four times that and the peak 1.5 px away: 65. Trained avatars have
 * κ = 1/12. */
constexpr float kTileMinKappaPx2 = 0.076f;

/** What the lists of compute tiles take, all of it before the first frame. Rows of tiles are counted over all views. */
struct TilePlan {
    gpu::TilePush push{};
    uint64_t tableWords = 0, sumWords = 0, spanBytes = 0, entryBytes = 0, pixelBytes = 0;
    uint32_t rows() const { return push.viewCount * push.rows; }
};

/** None when the tables of this many splats and pixels do not fit the device. Lists that turn out too small in a frame leave that frame to
 * the quads. */
std::optional<TilePlan> planTiles(const FrameIds& ids, const DeviceInfo& device);

/** The kernel that fills such frames at this many samples a pixel. */
std::string tileFillOf(const FrameIds& ids, uint32_t samples);

/** Sorted survivors to the tiles' lists, near first in each, and these to ids.tilePixels: RGBA8 of all views, then the depth sums. Sets the
 * draw's arguments to nothing unless a list was too small: then the pixels are in the target. */
void addTiles(FramePlan& plan, const FrameIds& ids, const TilePlan& tiles);

}  // namespace dpl
