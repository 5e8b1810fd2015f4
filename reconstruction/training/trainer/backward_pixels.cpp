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

/** Inputs and running state of one tile, small enough for the first-level cache. Pixels outside the image have stop 0. Arrays of two are
 * for splats of the body and of cloth. */
struct alignas(64) TileState {
    float red[kTilePixels], green[kTilePixels], blue[kTilePixels];  // gradients
    float cover[2][kTilePixels];                                    // gradient on alpha, for cloth with that on its share
    float colourShare[2][kTilePixels];
    float transmittance[kTilePixels], rest[kTilePixels];
    int32_t stop[kTilePixels];  // number of entries that the pixel blended
    int32_t rowStop[kTile];     // the largest of a row
};

}  // namespace dpl
#endif

HWY_BEFORE_NAMESPACE();
namespace dpl {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr float kLog2E = 1.44269504f;
constexpr float kLog2MinAlpha = -7.99435344f;  // log2(1/255)

/** 2^p for p in [-126, 127], as the blend computes it: what it drew is what this replays. */
template <class D, class V = hn::Vec<D>>
HWY_INLINE V exp2Of(D d, V p) {
    const hn::RebindToSigned<D> di;
    const auto whole = hn::NearestInt(p);
    const V f = hn::Sub(p, hn::ConvertTo(d, whole));
    V r = hn::MulAdd(f, hn::Set(d, 1.327647198e-03f), hn::Set(d, 9.675541334e-03f));
    r = hn::MulAdd(r, f, hn::Set(d, 5.550713274e-02f));
    r = hn::MulAdd(r, f, hn::Set(d, 2.402211972e-01f));
    r = hn::MulAdd(r, f, hn::Set(d, 6.931469671e-01f));
    r = hn::MulAdd(r, f, hn::Set(d, 1.0f));
    return hn::BitCast(d, hn::Add(hn::BitCast(di, r), hn::ShiftLeft<23>(whole)));
}

/** A splat in the tile: its centre, from that of the tile's first pixel, and the part of its box inside, in pixel indices; last included.
 */
struct EntryPlace {
    float x, y;
    int x0, x1, y0, y1;
};

/** Replays entry `index` of the tile over the rows and columns of its box, which is not empty. A row is kVectors vectors of D. */
template <int kVectors, class D>
HWY_INLINE void replayEntry(D d, TileState& tile, const ProjectedSplat& p, int32_t index, const EntryPlace& place, EntrySums& out) {
    using V = hn::Vec<D>;
    const hn::RebindToSigned<D> di;
    constexpr int lanes = int(hn::MaxLanes(D()));
    const V zero = hn::Zero(d);
    V s = zero, sx = zero, sy = zero, sxx = zero, sxy = zero, syy = zero, red = zero, green = zero, blue = zero, weight = zero;
    const int start = std::min(place.x0, kTile - kVectors * lanes);
    const float slope = p.conicB / p.conicA, rowScale = -0.5f * kLog2E * p.inverseVarianceY;
    const float logOpacity = 0.5f * kLog2E * p.inverseVarianceY * p.radiusY * p.radiusY + kLog2MinAlpha;  // as in the blend
    const V scale = hn::Set(d, -0.5f * kLog2E * p.conicA);
    const V r = hn::Set(d, p.red), g = hn::Set(d, p.green), b = hn::Set(d, p.blue);
    const V one = hn::Set(d, 1.0f), logMin = hn::Set(d, kLog2MinAlpha), maxAlpha = hn::Set(d, float(kMaxAlpha));
    const auto entry = hn::Set(di, index);
    const int kind = p.cloth > 0.5f;
    const float *share = tile.colourShare[kind], *cover = tile.cover[kind];
    V dx[kVectors];
    for (int k = 0; k < kVectors; ++k) dx[k] = hn::Sub(hn::ConvertTo(d, hn::Iota(di, start + k * lanes)), hn::Set(d, place.x));

    for (int y = place.y0; y <= place.y1; ++y) {
        if (index >= tile.rowStop[y]) continue;
        const float dyScalar = float(y) - place.y;
        const V dy = hn::Set(d, dyScalar), shift = hn::Set(d, slope * dyScalar);
        const V rowExponent = hn::Set(d, logOpacity + rowScale * dyScalar * dyScalar);
        V rowS = zero, rowX = zero, rowXx = zero;
        for (int k = 0; k < kVectors; ++k) {
            const int at = y * kTile + start + k * lanes;
            const V along = hn::Add(dx[k], shift);
            const V exponent = hn::MulAdd(hn::Mul(along, along), scale, rowExponent);
            const auto live = hn::RebindMask(d, hn::Lt(entry, hn::LoadU(di, tile.stop + at)));
            const auto mask = hn::And(hn::Ge(exponent, logMin), live);
            const V raw = exp2Of(d, exponent);
            const V alpha = hn::IfThenElseZero(mask, hn::Min(raw, maxAlpha));
            const V t = hn::LoadU(d, tile.transmittance + at);
            const V gr = hn::LoadU(d, tile.red + at), gg = hn::LoadU(d, tile.green + at), gb = hn::LoadU(d, tile.blue + at);
            const V v = hn::MulAdd(gr, r, hn::MulAdd(gg, g, hn::MulAdd(gb, b, hn::LoadU(d, cover + at))));
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
            const V gSigmaX = hn::Mul(gSigma, dx[k]);
            rowS = hn::Add(rowS, gSigma), rowX = hn::Add(rowX, gSigmaX), rowXx = hn::MulAdd(gSigmaX, dx[k], rowXx);
        }
        s = hn::Add(s, rowS), sx = hn::Add(sx, rowX), sxx = hn::Add(sxx, rowXx);
        const V rowY = hn::Mul(rowS, dy);
        sy = hn::Add(sy, rowY), syy = hn::MulAdd(rowY, dy, syy), sxy = hn::MulAdd(rowX, dy, sxy);
    }
    const auto sum = [d](V v) { return hn::GetLane(hn::SumOfLanes(d, v)); };
    out = {sum(s), sum(sx), sum(sy), sum(sxx), sum(sxy), sum(syy), sum(red), sum(green), sum(blue), sum(weight), 0, 0};
}

/** Most splats are narrow. Half a row then costs half as much where a whole one is two vectors, or one that the processor splits. */
HWY_INLINE void replayEntry(TileState& tile, const ProjectedSplat& p, int32_t index, float originX, float originY, EntrySums& out) {
    using Half = hn::CappedTag<float, kTile / 2>;
    using Whole = hn::CappedTag<float, kTile>;
    constexpr int kHalf = kTile / 2 / int(hn::MaxLanes(Half())), kWhole = kTile / int(hn::MaxLanes(Whole()));
    const float relX = p.x - originX, relY = p.y - originY;
    const EntryPlace place{relX,
                           relY,
                           int(std::max(0.0f, std::ceil(relX - p.radiusX))),
                           int(std::min(float(kTile - 1), std::floor(relX + p.radiusX))),
                           int(std::max(0.0f, std::ceil(relY - p.radiusY))),
                           int(std::min(float(kTile - 1), std::floor(relY + p.radiusY)))};
    if (place.x1 < place.x0 || place.y1 < place.y0)
        out = {};
    else if (place.x1 - place.x0 < kTile / 2)
        replayEntry<kHalf>(Half(), tile, p, index, place, out);
    else
        replayEntry<kWhole>(Whole(), tile, p, index, place, out);
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

namespace {

/** Fills the tile at column x0 and row y0 of the picture. first: index of the tile's first entry. Returns the largest stop. */
int32_t loadTile(const SplatImage& image, const ImageGradient& gradient, const uint32_t* stops, uint32_t first, size_t x0, size_t y0,
                 TileState& tile) {
    const bool withCloth = !gradient.cloth.empty() && !image.cloth.empty();
    const size_t width = image.widthPx, columns = std::min<size_t>(kTile, width - x0), rows = std::min<size_t>(kTile, image.heightPx - y0);
    if (columns < size_t(kTile) || rows < size_t(kTile)) std::memset(&tile, 0, sizeof tile);
    std::fill_n(tile.transmittance, kTilePixels, 1.0f);
    int32_t used = 0;
    for (size_t y = 0; y < rows; ++y) {
        const size_t at = y * kTile, pixel = (y0 + y) * width + x0;
        const float* rgb = image.rgb.data() + pixel * 3;
        std::copy_n(gradient.red.data() + pixel, columns, tile.red + at);
        std::copy_n(gradient.green.data() + pixel, columns, tile.green + at);
        std::copy_n(gradient.blue.data() + pixel, columns, tile.blue + at);
        std::copy_n(gradient.alpha.data() + pixel, columns, tile.cover[0] + at);
        for (size_t x = 0; x < columns; ++x)
            tile.rest[at + x] = tile.red[at + x] * rgb[3 * x] + tile.green[at + x] * rgb[3 * x + 1] + tile.blue[at + x] * rgb[3 * x + 2] +
                                tile.cover[0][at + x] * image.alpha[pixel + x];
        for (size_t kind = 0; kind < 2; ++kind)
            if (withCloth)
                std::copy_n(gradient.colourShare[kind].data() + pixel, columns, tile.colourShare[kind] + at);
            else
                std::fill_n(tile.colourShare[kind] + at, columns, 1.0f);
        for (size_t x = 0; x < columns; ++x) {
            const float cloth = withCloth ? gradient.cloth[pixel + x] : 0.0f;
            tile.cover[1][at + x] = tile.cover[0][at + x] + cloth;
            if (withCloth) tile.rest[at + x] += cloth * image.cloth[pixel + x];
        }
        int32_t most = 0;
        for (size_t x = 0; x < columns; ++x) {
            const uint32_t stop = stops[pixel + x];
            most = std::max(most, tile.stop[at + x] = stop > first ? int32_t(stop - first) : 0);
        }
        tile.rowStop[y] = most;
        used = std::max(used, most);
    }
    return used;
}

}  // namespace

void PixelBackward::run(const SplatEngine& engine, const SplatImage& image, const ImageGradient& gradient) {
    const TileLists& tiles = engine.tiles();
    const auto projected = engine.projected();
    const auto stops = engine.stops();
    const size_t entryCount = tiles.offset.empty() ? 0 : tiles.offset.back();  // tiles.entries may be longer: it never shrinks
    entries_.resize(std::max(entries_.size(), entryCount));
    jobs_.forBlocks(size_t(tiles.columns) * tiles.rows, [&](size_t t, uint32_t) {
        const uint32_t first = tiles.offset[t], count = tiles.offset[t + 1] - first;
        if (count == 0) return;
        TileState tile;
        const size_t x0 = t % tiles.columns * kTile, y0 = t / tiles.columns * kTile;
        const uint32_t used = std::min(count, uint32_t(loadTile(image, gradient, stops.data(), first, x0, y0, tile)));
        HWY_DYNAMIC_DISPATCH(replayTile)
        (tile, projected.data(), tiles.entries.data() + first, used, float(x0) + 0.5f, float(y0) + 0.5f, entries_.data() + first);
        std::memset(static_cast<void*>(entries_.data() + first + used), 0, (count - used) * sizeof(EntrySums));
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
    const auto g =
        BackwardFormulas<float>::footprintGradient(p.conicA, p.conicB, p.conicC, p.opacity, s.s, s.sx, s.sy, s.sxx, s.sxy, s.syy);
    return {g.x, g.y, g.conicA, g.conicB, g.conicC, g.opacity, {s.red, s.green, s.blue}};
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
