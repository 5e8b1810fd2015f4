// Front-to-back blending, one 16×16 tile at a time.
#include <algorithm>
#include <cmath>

#include "sdk/splat/buffers.h"

namespace dpl {

void blendTiles(Jobs& jobs, SplatEngine::Buffers& buffers, SplatImage& image, const BlendOptions& options) {
    const size_t width = buffers.widthPx, height = buffers.heightPx, pixels = width * height;
    image.widthPx = buffers.widthPx, image.heightPx = buffers.heightPx;
    image.rgb.resize(pixels * 3);
    image.alpha.resize(pixels);
    image.cloth.resize(options.cloth ? pixels : 0);
    image.depthM.resize(options.depth ? pixels : 0);
    buffers.stops.resize(options.recordStops ? pixels : 0);
    buffers.stopTransmittance.resize(options.recordStops ? pixels : 0);
    const TileLists& tiles = buffers.tiles;
    jobs.forBlocks(size_t(tiles.columns) * tiles.rows, [&](size_t tile, uint32_t) {
        const size_t x0 = tile % tiles.columns * kTileSizePx, y0 = tile / tiles.columns * kTileSizePx;
        for (size_t y = y0; y < std::min<size_t>(height, y0 + kTileSizePx); ++y)
            for (size_t x = x0; x < std::min<size_t>(width, x0 + kTileSizePx); ++x) {
                float t = 1, cloth = 0, depth = 0;
                Vec3f colour(0);
                uint32_t stop = tiles.offset[tile];
                for (uint32_t e = tiles.offset[tile]; e < tiles.offset[tile + 1] && t > float(kMinTransmittance); ++e) {
                    const ProjectedSplat& p = buffers.projected[tiles.entries[e]];
                    const float dx = float(x) + 0.5f - p.x, dy = float(y) + 0.5f - p.y;
                    const float along = dx + p.conicB / p.conicA * dy;
                    const float sigma = 0.5f * (p.conicA * along * along + buffers.rowScale[p.splat] * dy * dy);
                    const float alpha = std::min(float(kMaxAlpha), p.opacity * std::exp(-sigma));
                    if (!(alpha >= float(kMinAlpha))) continue;
                    const float w = alpha * t;
                    colour += w * Vec3f(p.red, p.green, p.blue);
                    cloth += w * p.cloth, depth += w * p.depthM;
                    t -= w;
                    stop = e + 1;
                }
                const size_t pixel = y * width + x;
                for (int k = 0; k < 3; ++k) image.rgb[pixel * 3 + k] = colour[k];
                image.alpha[pixel] = 1 - t;
                if (options.cloth) image.cloth[pixel] = cloth;
                if (options.depth) image.depthM[pixel] = t < 1 ? depth / (1 - t) : 0;
                if (options.recordStops) buffers.stops[pixel] = stop, buffers.stopTransmittance[pixel] = t;
            }
    });
}

}  // namespace dpl
