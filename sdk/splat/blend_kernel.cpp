// SPDX-License-Identifier: Apache-2.0
// Blends the splats of one tile front to back, a row of pixels at a time.
//
// In a row at distance dy from the splat's centre, −σ = −½A (x − x_row)² − ½ dy²/Σ'yy with x_row = centre − (B/A)·dy. This form does not
// cancel for needles and costs two operations a pixel. The logarithm of the opacity is added to the exponent, so the cut-off α ≥ 1/255 is
// a comparison before the exponential.
#include "sdk/splat/simd.h"

#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sdk/splat/blend_kernel.cpp"
#include <hwy/foreach_target.h>  // compiles this file once per instruction set; must come before the other Highway headers

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "sdk/splat/blend_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace dpl {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<float, kTileSizePx>;
using V = hn::Vec<D>;
constexpr uint32_t kLanes = uint32_t(hn::MaxLanes(D())), kChunks = kTileSizePx / kLanes;
constexpr float kLog2E = 1.44269504f;
constexpr float kLog2MinAlpha = -7.99435344f;  // log2(1/255)

// A splat that touches one half of a row needs only this. Half a vector costs half as much on processors that split wide ones.
using HalfD = hn::CappedTag<float, kTileSizePx / 2>;
constexpr uint32_t kHalfLanes = uint32_t(hn::MaxLanes(HalfD()));

HWY_INLINE V set(float x) {
    return hn::Set(D(), x);
}

/** 2^p for p in [-126, 127]: minimax polynomial of degree 5 on [-½, ½], relative error 8e-8. Outside, the result is undefined but nothing
 *  traps. */
template <class Lanes, class Vector = hn::Vec<Lanes>>
HWY_INLINE Vector exp2Of(Lanes d, Vector p) {
    const hn::RebindToSigned<Lanes> di;
    const auto whole = hn::NearestInt(p);
    const Vector f = p - hn::ConvertTo(d, whole);
    Vector r = hn::MulAdd(f, hn::Set(d, 1.327647198e-03f), hn::Set(d, 9.675541334e-03f));
    r = hn::MulAdd(r, f, hn::Set(d, 5.550713274e-02f));
    r = hn::MulAdd(r, f, hn::Set(d, 2.402211972e-01f));
    r = hn::MulAdd(r, f, hn::Set(d, 6.931469671e-01f));
    r = hn::MulAdd(r, f, hn::Set(d, 1.f));
    return hn::BitCast(d, hn::BitCast(di, r) + hn::ShiftLeft<23>(whole));
}

/** Pixels [first, last] of the tile within centre ± radius; false when there are none. Positions count from the centre of pixel 0. */
HWY_INLINE bool clipToTile(float centre, float radius, uint32_t& first, uint32_t& last) {
    constexpr float kLast = float(kTileSizePx - 1);
    const float low = centre - radius + 0.9999f, high = centre + radius;  // truncation below then rounds low up and high down
    if (!(high >= 0) || !(low < kLast + 1)) return false;
    first = uint32_t(int32_t(low > 0 ? low : 0)), last = uint32_t(int32_t(high < kLast ? high : kLast));
    return true;
}

/** Constants of one splat in the inner loop. */
template <class Lanes>
struct SplatRow {
    hn::Vec<Lanes> scale, red, green, blue, cloth, depth;
    hn::Vec<hn::RebindToUnsigned<Lanes>> next;  // index of the entry + 1
};

template <bool kCloth, bool kDepth, bool kStops, bool kScene, class Lanes>
HWY_INLINE SplatRow<Lanes> splatRow(Lanes d, const ProjectedSplat& p, uint32_t next) {
    SplatRow<Lanes> s;
    s.scale = hn::Set(d, -0.5f * kLog2E * p.conicA);
    s.red = hn::Set(d, p.red), s.green = hn::Set(d, p.green), s.blue = hn::Set(d, p.blue);
    if constexpr (kCloth) s.cloth = hn::Set(d, p.cloth);
    if constexpr (kDepth || kScene) s.depth = hn::Set(d, p.depthM);
    if constexpr (kStops) s.next = hn::Set(hn::RebindToUnsigned<Lanes>(), next);
    return s;
}

template <bool kCloth, bool kDepth, bool kStops, bool kScene, class Lanes, class Vector = hn::Vec<Lanes>>
HWY_INLINE void blendChunk(const SplatRow<Lanes>& s, Vector pixelX, float rowX, float rowExponent, uint32_t at, const float* farthestSeenM,
                           TileAccumulators& tile) {
    const Lanes d;
    const hn::RebindToUnsigned<Lanes> du;
    const Vector dx = pixelX - hn::Set(d, rowX);
    const Vector exponent = hn::MulAdd(dx * dx, s.scale, hn::Set(d, rowExponent));
    const Vector t = hn::Load(d, tile.transmittance + at);
    auto counts = hn::And(exponent >= hn::Set(d, kLog2MinAlpha), t > hn::Set(d, float(kMinTransmittance)));
    if constexpr (kScene) counts = hn::And(counts, s.depth <= hn::Load(d, farthestSeenM + at));
    const Vector w = hn::IfThenElseZero(counts, hn::Min(exp2Of(d, exponent), hn::Set(d, float(kMaxAlpha)))) * t;
    hn::Store(hn::MulAdd(w, s.red, hn::Load(d, tile.red + at)), d, tile.red + at);
    hn::Store(hn::MulAdd(w, s.green, hn::Load(d, tile.green + at)), d, tile.green + at);
    hn::Store(hn::MulAdd(w, s.blue, hn::Load(d, tile.blue + at)), d, tile.blue + at);
    hn::Store(t - w, d, tile.transmittance + at);
    if constexpr (kCloth) hn::Store(hn::MulAdd(w, s.cloth, hn::Load(d, tile.cloth + at)), d, tile.cloth + at);
    if constexpr (kDepth) hn::Store(hn::MulAdd(w, s.depth, hn::Load(d, tile.depth + at)), d, tile.depth + at);
    if constexpr (kStops) hn::BlendedStore(s.next, hn::RebindMask(du, counts), du, tile.stop + at);
}

template <bool kCloth, bool kDepth, bool kStops, bool kScene>
void blendTileAs(const BlendTileTask& task, TileAccumulators& tile) {
    const D d;
    const hn::RebindToUnsigned<D> du;
    const V zero = hn::Zero(d), one = set(1);
    for (uint32_t i = 0; i < kTilePixels; i += kLanes) {
        hn::Store(zero, d, tile.red + i), hn::Store(zero, d, tile.green + i), hn::Store(zero, d, tile.blue + i);
        hn::Store(one, d, tile.transmittance + i);
        if constexpr (kCloth) hn::Store(zero, d, tile.cloth + i);
        if constexpr (kDepth) hn::Store(zero, d, tile.depth + i);
        if constexpr (kStops) hn::Store(hn::Set(du, task.begin), du, tile.stop + i);
    }
    V pixelX[kChunks];  // relative to the centre of the tile's first pixel
    for (uint32_t c = 0; c < kChunks; ++c) pixelX[c] = hn::Iota(d, float(c * kLanes));
    const float originX = task.x0 + 0.5f, originY = task.y0 + 0.5f;
    constexpr uint32_t kAllRows = (1u << kTileSizePx) - 1, kCheckEvery = 32, kAhead = 12;
    uint32_t doneRows = 0;

    for (uint32_t e = task.begin; e < task.end; ++e) {
        if (e + kAhead < task.end) hwy::Prefetch(task.projected + task.entries[e + kAhead]);
        const ProjectedSplat& p = task.projected[task.entries[e]];
        const float x = p.x - originX, y = p.y - originY;
        uint32_t firstX, lastX, firstY, lastY;
        if (!clipToTile(x, p.radiusX, firstX, lastX)) continue;
        if (!clipToTile(y, p.radiusY, firstY, lastY)) continue;
        const float slope = p.conicB / p.conicA, rowScale = -0.5f * kLog2E * p.inverseVarianceY;
        // log2(opacity): radiusY² / Σ'yy = 2 ln(255·opacity)
        const float logOpacity = 0.5f * kLog2E * p.inverseVarianceY * p.radiusY * p.radiusY + kLog2MinAlpha;
        const auto forRows = [&](auto&& blendRow) HWY_ATTR {
            for (uint32_t row = firstY; row <= lastY; ++row) {
                if (doneRows >> row & 1) continue;
                const float dy = float(int32_t(row)) - y;
                blendRow(row * kTileSizePx, x - slope * dy, logOpacity + rowScale * dy * dy);
            }
        };
        if (kHalfLanes < kLanes && firstX / kHalfLanes == lastX / kHalfLanes) {
            const HalfD half;
            const auto s = splatRow<kCloth, kDepth, kStops, kScene>(half, p, e + 1);
            const uint32_t column = firstX / kHalfLanes * kHalfLanes;
            const auto columnX = hn::Iota(half, float(column));
            forRows([&](uint32_t at, float rowX, float rowExponent) HWY_ATTR {
                blendChunk<kCloth, kDepth, kStops, kScene>(s, columnX, rowX, rowExponent, at + column, task.farthestSeenM, tile);
            });
        } else {
            const auto s = splatRow<kCloth, kDepth, kStops, kScene>(d, p, e + 1);
            const uint32_t firstChunk = firstX / kLanes, lastChunk = lastX / kLanes;
            forRows([&](uint32_t at, float rowX, float rowExponent) HWY_ATTR {
                for (uint32_t c = firstChunk; c <= lastChunk; ++c)
                    blendChunk<kCloth, kDepth, kStops, kScene>(s, pixelX[c], rowX, rowExponent, at + c * kLanes, task.farthestSeenM, tile);
            });
        }
        if ((e - task.begin) % kCheckEvery == kCheckEvery - 1) {
            for (uint32_t row = 0; row < kTileSizePx; ++row) {
                V most = hn::Load(d, tile.transmittance + row * kTileSizePx);
                for (uint32_t c = 1; c < kChunks; ++c)
                    most = hn::Max(most, hn::Load(d, tile.transmittance + row * kTileSizePx + c * kLanes));
                if (hn::AllTrue(d, most <= set(float(kMinTransmittance)))) doneRows |= 1u << row;
            }
            if (doneRows == kAllRows) break;
        }
    }
}

template <bool kScene>
void blendTileIn(const BlendTileTask& task, TileAccumulators& tile) {
    using Kernel = void (*)(const BlendTileTask&, TileAccumulators&);
    static constexpr Kernel kKernels[2][2][2] = {{{blendTileAs<false, false, false, kScene>, blendTileAs<false, false, true, kScene>},
                                                  {blendTileAs<false, true, false, kScene>, blendTileAs<false, true, true, kScene>}},
                                                 {{blendTileAs<true, false, false, kScene>, blendTileAs<true, false, true, kScene>},
                                                  {blendTileAs<true, true, false, kScene>, blendTileAs<true, true, true, kScene>}}};
    kKernels[task.cloth][task.depth][task.stops](task, tile);
}

void blendTile(const BlendTileTask& task, TileAccumulators& tile) {
    if (task.farthestSeenM)
        blendTileIn<true>(task, tile);
    else
        blendTileIn<false>(task, tile);
}

void packRgba8(const TileAccumulators& tile, uint32_t row, uint32_t width, uint8_t* rgba) {
    const D d;
    const hn::RebindToUnsigned<D> du;
    HWY_ALIGN uint32_t pixels[kTileSizePx];
    const auto unorm8 = [&](V x) HWY_ATTR { return hn::BitCast(du, hn::NearestInt(hn::Min(x, set(1)) * set(255))); };
    for (uint32_t x = 0; x < kTileSizePx; x += kLanes) {
        const uint32_t at = row * kTileSizePx + x;
        const auto r = unorm8(hn::Load(d, tile.red + at)), g = unorm8(hn::Load(d, tile.green + at)),
                   b = unorm8(hn::Load(d, tile.blue + at));
        const auto a = unorm8(set(1) - hn::Load(d, tile.transmittance + at));
        hn::Store(hn::Or(hn::Or(r, hn::ShiftLeft<8>(g)), hn::Or(hn::ShiftLeft<16>(b), hn::ShiftLeft<24>(a))), du, pixels + x);
    }
    std::memcpy(rgba, pixels, width * 4);
}

void storeRow(const TileAccumulators& tile, uint32_t row, uint32_t width, float* rgb, float* alpha) {
    const D d;
    HWY_ALIGN float rowRgb[3 * kTileSizePx], rowAlpha[kTileSizePx];
    for (uint32_t x = 0; x < kTileSizePx; x += kLanes) {
        const uint32_t at = row * kTileSizePx + x;
        hn::StoreInterleaved3(hn::Load(d, tile.red + at), hn::Load(d, tile.green + at), hn::Load(d, tile.blue + at), d, rowRgb + 3 * x);
        hn::Store(set(1) - hn::Load(d, tile.transmittance + at), d, rowAlpha + x);
    }
    std::memcpy(rgb, rowRgb, width * 3 * sizeof(float));
    std::memcpy(alpha, rowAlpha, width * sizeof(float));
}

}  // namespace HWY_NAMESPACE
}  // namespace dpl
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dpl {
HWY_EXPORT(blendTile);
HWY_EXPORT(packRgba8);
HWY_EXPORT(storeRow);
void blendTile(const BlendTileTask& task, TileAccumulators& tile) {
    HWY_DYNAMIC_DISPATCH(blendTile)(task, tile);
}
void packRgba8(const TileAccumulators& tile, uint32_t row, uint32_t width, uint8_t* rgba) {
    HWY_DYNAMIC_DISPATCH(packRgba8)(tile, row, width, rgba);
}
void storeRow(const TileAccumulators& tile, uint32_t row, uint32_t width, float* rgb, float* alpha) {
    HWY_DYNAMIC_DISPATCH(storeRow)(tile, row, width, rgb, alpha);
}
}  // namespace dpl
#endif
