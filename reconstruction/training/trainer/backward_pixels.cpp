// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruction/training/trainer/backward_pixels.cpp"
#include "hwy/foreach_target.h"  // compiles this file once per instruction set; must come before the other Highway headers

#include "hwy/cache_control.h"
#include "hwy/highway.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "reconstruction/training/trainer/backward_pixels.h"

#ifndef DPL_BACKWARD_PIXELS_ONCE
#define DPL_BACKWARD_PIXELS_ONCE
namespace dpl {

constexpr int kTile = int(kTileSizePx), kTilePixels = kTile * kTile;

/** Inputs and running state of one tile, small enough for the first-level cache. Pixels outside the image have stop 0. */
struct alignas(64) TileState {
    float red[kTilePixels], green[kTilePixels], blue[kTilePixels], cloth[kTilePixels], alpha[kTilePixels];  // gradients
    float transmittance[kTilePixels], rest[kTilePixels];
    float colourShare[2][kTilePixels];  // of splats of the body, of cloth
    int32_t stop[kTilePixels];          // number of entries that the pixel blended
};

}  // namespace dpl
#endif

HWY_BEFORE_NAMESPACE();
namespace dpl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

/** exp(x) for x in [-20, 0], as 2^(i+f) with a degree-6 polynomial on f in [-½, ½]. Relative error below 2e-7. */
HWY_INLINE V expNegative(D d, V x) {
    const hn::RebindToSigned<D> di;
    const V t = hn::Max(hn::Mul(x, hn::Set(d, 1.44269504088896f)), hn::Set(d, -126.0f));
    const V whole = hn::Round(t);
    const V f = hn::Sub(t, whole);
    V p = hn::Set(d, 1.5403530e-4f);
    p = hn::MulAdd(p, f, hn::Set(d, 1.3333558e-3f));
    p = hn::MulAdd(p, f, hn::Set(d, 9.6181291e-3f));
    p = hn::MulAdd(p, f, hn::Set(d, 5.5504109e-2f));
    p = hn::MulAdd(p, f, hn::Set(d, 0.24022651f));
    p = hn::MulAdd(p, f, hn::Set(d, 0.69314718f));
    p = hn::MulAdd(p, f, hn::Set(d, 1.0f));
    const auto exponent = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, whole), hn::Set(di, 127)));
    return hn::Mul(p, hn::BitCast(d, exponent));
}

/** Replays entry `index` of the tile over the rows and columns that its box touches. originX, originY: centre of the tile's first pixel. */
HWY_INLINE void replayEntry(TileState& tile, const ProjectedSplat& p, int32_t index, float originX, float originY, EntrySums& out) {
    const D d;
    const hn::RebindToSigned<D> di;
    constexpr int lanes = int(hn::MaxLanes(D()));
    const V zero = hn::Zero(d);
    V s = zero, sx = zero, sy = zero, sxx = zero, sxy = zero, syy = zero, red = zero, green = zero, blue = zero, weight = zero;

    // The splat's box in pixel indices of the tile.
    const float relX = p.x - originX, relY = p.y - originY;
    const int x0 = int(std::max(0.0f, std::ceil(relX - p.radiusX))), x1 = int(std::min(float(kTile - 1), std::floor(relX + p.radiusX)));
    const int y0 = int(std::max(0.0f, std::ceil(relY - p.radiusY))), y1 = int(std::min(float(kTile - 1), std::floor(relY + p.radiusY)));
    if (x1 < x0 || y1 < y0) return;
    const int vectors = (x1 - x0) / lanes + 1;
    const int start = std::min(x0, kTile - vectors * lanes);

    const V ratio = hn::Set(d, p.conicB / p.conicA);
    const V halfA = hn::Set(d, -0.5f * p.conicA), opacity = hn::Set(d, p.opacity);
    const V r = hn::Set(d, p.red), g = hn::Set(d, p.green), b = hn::Set(d, p.blue), cloth = hn::Set(d, p.cloth);
    const V one = hn::Set(d, 1.0f), minAlpha = hn::Set(d, float(kMinAlpha)), maxAlpha = hn::Set(d, float(kMaxAlpha));
    const auto entry = hn::Set(di, index);
    const float* share = tile.colourShare[p.cloth > 0.5f];

    for (int y = y0; y <= y1; ++y) {
        const float dyScalar = float(y) - relY;
        const V dy = hn::Set(d, dyScalar);
        const V rowPower = hn::Set(d, -0.5f * p.inverseVarianceY * dyScalar * dyScalar);
        V rowS = zero, rowX = zero, rowXx = zero;
        for (int k = 0; k < vectors; ++k) {
            const int x = start + k * lanes, at = y * kTile + x;
            const V dx = hn::Sub(hn::ConvertTo(d, hn::Iota(di, x)), hn::Set(d, relX));
            const V along = hn::MulAdd(ratio, dy, dx);
            const V power = hn::MulAdd(halfA, hn::Mul(along, along), rowPower);
            const V raw = hn::Mul(opacity, expNegative(d, power));
            const auto live = hn::RebindMask(d, hn::Lt(entry, hn::LoadU(di, tile.stop + at)));
            const auto mask = hn::And(hn::Ge(raw, minAlpha), live);
            const V alpha = hn::IfThenElseZero(mask, hn::Min(raw, maxAlpha));
            const V t = hn::LoadU(d, tile.transmittance + at);
            const V gr = hn::LoadU(d, tile.red + at), gg = hn::LoadU(d, tile.green + at), gb = hn::LoadU(d, tile.blue + at);
            V v = hn::MulAdd(cloth, hn::LoadU(d, tile.cloth + at), hn::LoadU(d, tile.alpha + at));
            v = hn::MulAdd(gr, r, hn::MulAdd(gg, g, hn::MulAdd(gb, b, v)));
            const V w = hn::Mul(alpha, t);
            const V rest = hn::NegMulAdd(w, v, hn::LoadU(d, tile.rest + at));
            const V through = hn::Sub(one, alpha);
            hn::StoreU(rest, d, tile.rest + at);
            hn::StoreU(hn::Mul(t, through), d, tile.transmittance + at);
            const V shared = hn::Mul(w, hn::LoadU(d, share + at));
            red = hn::MulAdd(shared, gr, red), green = hn::MulAdd(shared, gg, green), blue = hn::MulAdd(shared, gb, blue);
            weight = hn::Add(weight, w);
            // g_σ = −α·g_α, and zero where α was capped.
            const V gSigma =
                hn::IfThenElseZero(hn::And(mask, hn::Le(raw, maxAlpha)), hn::Sub(hn::Div(hn::Mul(alpha, rest), through), hn::Mul(w, v)));
            const V gSigmaX = hn::Mul(gSigma, dx);
            rowS = hn::Add(rowS, gSigma), rowX = hn::Add(rowX, gSigmaX), rowXx = hn::MulAdd(gSigmaX, dx, rowXx);
        }
        s = hn::Add(s, rowS), sx = hn::Add(sx, rowX), sxx = hn::Add(sxx, rowXx);
        const V rowY = hn::Mul(rowS, dy);
        sy = hn::Add(sy, rowY), syy = hn::MulAdd(rowY, dy, syy), sxy = hn::MulAdd(rowX, dy, sxy);
    }
    const auto sum = [d](V v) { return hn::GetLane(hn::SumOfLanes(d, v)); };
    out.s = sum(s), out.sx = sum(sx), out.sy = sum(sy), out.sxx = sum(sxx), out.sxy = sum(sxy), out.syy = sum(syy);
    out.red = sum(red), out.green = sum(green), out.blue = sum(blue), out.weight = sum(weight);
}

void replayTile(TileState& tile, const ProjectedSplat* projected, const uint32_t* entries, uint32_t count, float originX, float originY,
                EntrySums* out) {
    constexpr uint32_t kAhead = 12;  // entries to prefetch, since their splats are scattered in memory
    for (uint32_t i = 0; i < count; ++i) {
        if (i + kAhead < count) hwy::Prefetch(projected + entries[i + kAhead]);
        replayEntry(tile, projected[entries[i]], int32_t(i), originX, originY, out[i]);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace dpl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dpl {
HWY_EXPORT(replayTile);

void ImageGradient::resize(uint32_t width, uint32_t height, bool withCloth) {
    widthPx = width, heightPx = height;
    const size_t count = size_t(width) * height;
    for (std::vector<float>* plane : {&red, &green, &blue, &alpha}) plane->resize(count);
    for (std::vector<float>* plane : {&cloth, &colourShare[0], &colourShare[1]}) plane->resize(withCloth ? count : 0, 1.0f);
}

void PixelBackward::run(const SplatEngine& engine, const SplatImage& image, const ImageGradient& gradient) {
    const TileLists& tiles = engine.tiles();
    const auto projected = engine.projected();
    const auto stops = engine.stops();
    const size_t width = image.widthPx, height = image.heightPx;
    const bool withCloth = !gradient.cloth.empty() && !image.cloth.empty();
    const size_t entryCount = tiles.offset.empty() ? 0 : tiles.offset.back();  // tiles.entries may be longer: it never shrinks
    entries_.resize(std::max(entries_.size(), entryCount));
    jobs_.forBlocks(size_t(tiles.columns) * tiles.rows, [&](size_t t, uint32_t) {
        const uint32_t first = tiles.offset[t], count = tiles.offset[t + 1] - first;
        if (count == 0) return;
        std::memset(entries_.data() + first, 0, count * sizeof(EntrySums));
        TileState tile;
        const size_t x0 = t % tiles.columns * kTile, y0 = t / tiles.columns * kTile;
        uint32_t used = 0;
        for (size_t y = 0; y < size_t(kTile); ++y)
            for (size_t x = 0; x < size_t(kTile); ++x) {
                const size_t at = y * kTile + x;
                tile.transmittance[at] = 1, tile.rest[at] = 0, tile.stop[at] = 0;
                tile.red[at] = tile.green[at] = tile.blue[at] = tile.cloth[at] = tile.alpha[at] = 0;
                tile.colourShare[0][at] = tile.colourShare[1][at] = 1;
                if (x0 + x >= width || y0 + y >= height) continue;
                const size_t pixel = (y0 + y) * width + x0 + x;
                tile.red[at] = gradient.red[pixel], tile.green[at] = gradient.green[pixel], tile.blue[at] = gradient.blue[pixel];
                tile.alpha[at] = gradient.alpha[pixel];
                float rest = tile.red[at] * image.rgb[pixel * 3] + tile.green[at] * image.rgb[pixel * 3 + 1] +
                             tile.blue[at] * image.rgb[pixel * 3 + 2] + tile.alpha[at] * image.alpha[pixel];
                if (withCloth) {
                    tile.cloth[at] = gradient.cloth[pixel];
                    for (size_t kind = 0; kind < 2; ++kind) tile.colourShare[kind][at] = gradient.colourShare[kind][pixel];
                    rest += tile.cloth[at] * image.cloth[pixel];
                }
                tile.rest[at] = rest;
                const uint32_t stop = stops[pixel] > first ? stops[pixel] - first : 0;
                tile.stop[at] = int32_t(stop);
                used = std::max(used, stop);
            }
        HWY_DYNAMIC_DISPATCH(replayTile)
        (tile, projected.data(), tiles.entries.data() + first, std::min(used, count), float(x0) + 0.5f, float(y0) + 0.5f,
         entries_.data() + first);
    });

    // Sums per splat in tile order. Each block owns a range of splats and reads the whole entry list, so the order of additions does
    // not depend on the number of blocks.
    sums_.resize(projected.size());
    const size_t blocks = std::max<size_t>(1, jobs_.threadCount());
    jobs_.forBlocks(blocks, [&](size_t block, uint32_t) {
        const uint32_t begin = uint32_t(sums_.size() * block / blocks), end = uint32_t(sums_.size() * (block + 1) / blocks);
        if (begin < end) std::memset(&sums_[begin], 0, (end - begin) * sizeof(EntrySums));
        const uint32_t* index = tiles.entries.data();
        for (size_t e = 0; e < entryCount; ++e) {
            const uint32_t splat = index[e];
            if (splat < begin || splat >= end) continue;
            float* to = &sums_[splat].s;
            const float* from = &entries_[e].s;
            for (int k = 0; k < 12; ++k) to[k] += from[k];
        }
    });
}

ScreenGradient<float> screenGradient(const ProjectedSplat& p, const EntrySums& s) {
    ScreenGradient<float> g;
    g.x = -(p.conicA * s.sx + p.conicB * s.sy);
    g.y = -(p.conicB * s.sx + p.conicC * s.sy);
    g.conicA = 0.5f * s.sxx, g.conicB = s.sxy, g.conicC = 0.5f * s.syy;
    g.opacity = p.opacity > 0 ? -s.s / p.opacity : 0.0f;
    g.colour = {s.red, s.green, s.blue};
    return g;
}

uint64_t countPixelSplatPairs(const SplatEngine& engine, uint32_t widthPx, uint32_t heightPx) {
    const TileLists& tiles = engine.tiles();
    const auto projected = engine.projected();
    const auto stops = engine.stops();
    uint64_t pairs = 0;
    for (uint32_t t = 0; t < tiles.columns * tiles.rows; ++t) {
        const uint32_t tileX = t % tiles.columns * kTileSizePx, tileY = t / tiles.columns * kTileSizePx;
        for (uint32_t e = tiles.offset[t]; e < tiles.offset[t + 1]; ++e) {
            const ProjectedSplat& p = projected[tiles.entries[e]];
            for (uint32_t y = tileY; y < std::min(heightPx, tileY + kTileSizePx); ++y) {
                if (std::abs(float(y) + 0.5f - p.y) > p.radiusY) continue;
                for (uint32_t x = tileX; x < std::min(widthPx, tileX + kTileSizePx); ++x)
                    if (std::abs(float(x) + 0.5f - p.x) <= p.radiusX && stops[size_t(y) * widthPx + x] > e) ++pairs;
            }
        }
    }
    return pairs;
}

}  // namespace dpl
#endif
