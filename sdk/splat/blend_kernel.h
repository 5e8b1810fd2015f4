// SPDX-License-Identifier: Apache-2.0
// The seam between blending's plumbing (splat_blend.cpp) and its SIMD kernel (blend_kernel.cpp). Private to sdk/splat.
#pragma once

#include "sdk/splat/buffers.h"

namespace dpl {

constexpr uint32_t kTilePixels = kTileSizePx * kTileSizePx;

/** Accumulators of one tile, row-major. 14 KB: they stay in L1 with the splats that come and go. */
struct alignas(64) TileAccumulators {
    float red[kTilePixels], green[kTilePixels], blue[kTilePixels], transmittance[kTilePixels];
    float cloth[kTilePixels], depth[kTilePixels];  // only when asked for
    uint32_t stop[kTilePixels];                    // the same
};

struct BlendTileTask {
    const ProjectedSplat* projected;
    const uint32_t* entries;     // the whole array
    uint32_t begin, end;         // this tile's part of it
    float x0, y0;                // top left pixel of the tile
    bool cloth, depth, stops;    // accumulators beyond colour and transmittance
    const float* farthestSeenM;  // kTilePixels, aligned: splats behind it add nothing; null: no scene
};

/** Sets every accumulator that is asked for. */
void blendTile(const BlendTileTask& task, TileAccumulators& tile);

/** Converts `width` ≤ 16 pixels of a row to premultiplied RGBA8. */
void packRgba8(const TileAccumulators& tile, uint32_t row, uint32_t width, uint8_t* rgba);

/** Interleaves `width` pixels of a row into rgb and writes 1 − T. */
void storeRow(const TileAccumulators& tile, uint32_t row, uint32_t width, float* rgb, float* alpha);

}  // namespace dpl
