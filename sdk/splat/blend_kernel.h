// SPDX-License-Identifier: Apache-2.0
// Interface between splat_blend.cpp, which hands tiles to workers, and its SIMD kernel blend_kernel.cpp. Private to sdk/splat.
#pragma once

#include "sdk/splat/buffers.h"

namespace dpl {

constexpr uint32_t kTilePixels = kTileSizePx * kTileSizePx;

/** Accumulators of one tile, row-major: 7 KB, so they stay in the L1 cache. */
struct alignas(64) TileAccumulators {
    float red[kTilePixels], green[kTilePixels], blue[kTilePixels], transmittance[kTilePixels];
    float cloth[kTilePixels], depth[kTilePixels];  // unused unless asked for
    uint32_t stop[kTilePixels];                    // one past the last blended entry; unused unless asked for
};

struct BlendTileTask {
    const ProjectedSplat* projected;
    const uint32_t* entries;     // of all tiles
    uint32_t begin, end;         // this tile's range of entries
    float x0, y0;                // top left pixel of the tile
    bool cloth, depth, stops;    // which optional accumulators to fill
    const float* farthestSeenM;  // kTilePixels, 64-byte aligned: splats behind it add nothing; null: no scene
};

/** Initialises and fills every accumulator that is asked for. */
void blendTile(const BlendTileTask& task, TileAccumulators& tile);

/** Writes the first `width` ≤ 16 pixels of a row as premultiplied RGBA8. */
void packRgba8(const TileAccumulators& tile, uint32_t row, uint32_t width, uint8_t* rgba);

/** Writes the first `width` pixels of a row: interleaved RGB and alpha = 1 − T. */
void storeRow(const TileAccumulators& tile, uint32_t row, uint32_t width, float* rgb, float* alpha);

}  // namespace dpl
