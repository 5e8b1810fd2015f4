// SPDX-License-Identifier: Apache-2.0
// Blending: hands tiles to workers and copies the finished accumulators into images.
#include <algorithm>
#include <cstring>

#include "sdk/math/scene_depth.h"
#include "sdk/splat/blend_kernel.h"

namespace dpl {
namespace {

/** The part of a tile inside the image. */
struct TileRect {
    uint32_t x, y, width, height;
};

/** Blends the tile once per coverage sample and writes the mean to `tile`. */
void blendSamples(BlendTileTask task, TileAccumulators& tile) {
    constexpr float kShare = 1.0f / kCoverageSamples;
    const float left = task.x0, top = task.y0;
    TileAccumulators sample;
    const auto add = [&](float* sums, const float* of, bool first) {
        for (uint32_t i = 0; i < kTilePixels; ++i) sums[i] = (first ? 0 : sums[i]) + kShare * of[i];
    };
    for (uint32_t k = 0; k < kCoverageSamples; ++k) {
        task.x0 = left + kCoverageSamplePx[k][0] - 0.5f, task.y0 = top + kCoverageSamplePx[k][1] - 0.5f;
        blendTile(task, sample);
        add(tile.red, sample.red, k == 0), add(tile.green, sample.green, k == 0), add(tile.blue, sample.blue, k == 0);
        add(tile.transmittance, sample.transmittance, k == 0);
        if (task.cloth) add(tile.cloth, sample.cloth, k == 0);
        if (task.depth) add(tile.depth, sample.depth, k == 0);
    }
}

/** Writes farthestSeenM of each pixel of one tile into seen[kTilePixels]. Pixels outside the image have no scene. */
void farthestSeenOf(std::span<const float> sceneDepthM, const TileRect& rect, size_t widthPx, float* seen) {
    std::fill_n(seen, kTilePixels, farthestSeenM(0));
    for (uint32_t row = 0; row < rect.height; ++row) {
        const float* from = sceneDepthM.data() + (rect.y + row) * widthPx + rect.x;
        std::transform(from, from + rect.width, seen + row * kTileSizePx, farthestSeenM);
    }
}

/** Blends every tile and calls finish(tile index, rect, accumulators); accumulators is null for tiles without splats. */
template <class Finish>
void forTiles(Jobs& jobs, const SplatEngine::Buffers& buffers, const BlendOptions& options, Finish&& finish) {
    const TileLists& tiles = buffers.tiles;
    jobs.forBlocks(tiles.rows, [&](size_t row, uint32_t) {
        TileAccumulators tile;
        alignas(64) float seen[kTilePixels];
        for (uint32_t column = 0; column < tiles.columns; ++column) {
            const size_t index = row * tiles.columns + column;
            TileRect rect{column * kTileSizePx, uint32_t(row) * kTileSizePx, 0, 0};
            rect.width = std::min(kTileSizePx, buffers.widthPx - rect.x), rect.height = std::min(kTileSizePx, buffers.heightPx - rect.y);
            const uint32_t begin = tiles.offset[index], end = tiles.offset[index + 1];
            if (begin == end) {
                finish(index, rect, static_cast<const TileAccumulators*>(nullptr));
                continue;
            }
            const BlendTileTask task{buffers.projected.data(),
                                     tiles.entries.data(),
                                     begin,
                                     end,
                                     float(rect.x),
                                     float(rect.y),
                                     options.cloth,
                                     options.depth,
                                     options.recordStops,
                                     options.sceneDepthM.empty() ? nullptr : seen};
            if (!options.sceneDepthM.empty()) farthestSeenOf(options.sceneDepthM, rect, buffers.widthPx, seen);
            if (buffers.samples > 1)
                blendSamples(task, tile);
            else
                blendTile(task, tile);
            finish(index, rect, static_cast<const TileAccumulators*>(&tile));
        }
    });
}

void storeDepthRow(const TileAccumulators* tile, uint32_t row, uint32_t width, float* depthM) {
    for (uint32_t x = 0; x < width; ++x) {
        const uint32_t at = row * kTileSizePx + x;
        const float covered = tile ? 1 - tile->transmittance[at] : 0.f;
        depthM[x] = covered > 0 ? tile->depth[at] / covered : 0.f;
    }
}

}  // namespace

void blendTiles(Jobs& jobs, SplatEngine::Buffers& buffers, SplatImage& image, const BlendOptions& options) {
    const size_t width = buffers.widthPx, pixels = width * buffers.heightPx;
    image.widthPx = buffers.widthPx, image.heightPx = buffers.heightPx;
    image.rgb.resize(pixels * 3);
    image.alpha.resize(pixels);
    image.cloth.resize(options.cloth ? pixels : 0);
    image.depthM.resize(options.depth ? pixels : 0);
    const bool stops = options.recordStops && buffers.samples == 1;
    buffers.stops.resize(stops ? pixels : 0);
    buffers.stopTransmittance.resize(stops ? pixels : 0);
    forTiles(jobs, buffers, {.cloth = options.cloth, .depth = options.depth, .recordStops = stops, .sceneDepthM = options.sceneDepthM},
             [&](size_t index, const TileRect& rect, const TileAccumulators* tile) {
                 for (uint32_t row = 0; row < rect.height; ++row) {
                     const size_t pixel = (rect.y + row) * width + rect.x, at = row * kTileSizePx;
                     if (tile) {
                         storeRow(*tile, row, rect.width, image.rgb.data() + pixel * 3, image.alpha.data() + pixel);
                     } else {
                         std::fill_n(image.rgb.data() + pixel * 3, rect.width * 3, 0.f);
                         std::fill_n(image.alpha.data() + pixel, rect.width, 0.f);
                     }
                     if (options.cloth) {
                         if (tile)
                             std::copy_n(tile->cloth + at, rect.width, image.cloth.data() + pixel);
                         else
                             std::fill_n(image.cloth.data() + pixel, rect.width, 0.f);
                     }
                     if (options.depth) storeDepthRow(tile, row, rect.width, image.depthM.data() + pixel);
                     if (!stops) continue;
                     for (uint32_t x = 0; x < rect.width; ++x) {
                         buffers.stops[pixel + x] = tile ? tile->stop[at + x] : buffers.tiles.offset[index];
                         buffers.stopTransmittance[pixel + x] = tile ? tile->transmittance[at + x] : 1.f;
                     }
                 }
             });
}

void blendTilesRgba8(Jobs& jobs, SplatEngine::Buffers& buffers, std::vector<uint8_t>& rgba, std::vector<float>* depthM,
                     std::span<const float> sceneDepthM) {
    const size_t width = buffers.widthPx, pixels = width * buffers.heightPx;
    rgba.resize(pixels * 4);
    if (depthM) depthM->resize(pixels);
    forTiles(jobs, buffers, {.depth = depthM != nullptr, .sceneDepthM = sceneDepthM},
             [&](size_t, const TileRect& rect, const TileAccumulators* tile) {
                 for (uint32_t row = 0; row < rect.height; ++row) {
                     const size_t pixel = (rect.y + row) * width + rect.x;
                     if (tile)
                         packRgba8(*tile, row, rect.width, rgba.data() + pixel * 4);
                     else
                         std::memset(rgba.data() + pixel * 4, 0, rect.width * 4);
                     if (depthM) storeDepthRow(tile, row, rect.width, depthM->data() + pixel);
                 }
             });
}

}  // namespace dpl
