// SPDX-License-Identifier: Apache-2.0
// Level of detail (docs/adr/0010): which splats of a half-chunk are drawn when its surface covers few pixels, how much of each, and by how
// much those grow.
//
//   splats wanted a square metre ─► share of the half-chunk ─► weight of each by its rank ─► opacity · weight, scale · growth
//
// Everything is continuous in the wanted density, so nothing pops while a camera moves; at a share of 1 all weights and the growth are
// exactly 1. shaders/lib/detail.glsl holds the same lines.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sdk/math/camera.h"

namespace dpl {

constexpr uint32_t kSplatGroupSize = 128;  // a half-chunk: splats [0, 128) or [128, 256) of a chunk
constexpr double kDetailFade = 0.5;        // splats whose rank lies within this share beyond the kept ones are fading
constexpr double kDetailThrough =
    0.02;  // of the light behind a surface: what may shine through it more than through all its splats, before the kept ones grow
constexpr double kDetailShFull = 0.25, kDetailShGone = 0.125;  // of an avatar's splats: bands of SH beyond 0 fade between these kept shares

/** What drawing wants of one avatar. */
struct SplatDetail {
    float perM2 = std::numeric_limits<float>::infinity();  // splats a square metre of surface at rest; infinite: all, exactly
    float shShare = 1;                                     // of SH beyond coefficient 0
    bool full() const { return !(perM2 < std::numeric_limits<float>::infinity()); }
};

/** The size of a pixel of one view, metres, at a point: dot(axis, point) + offset. */
struct PixelPlane {
    Vec3f axis{0};
    float offsetM = 0;
};

inline PixelPlane pixelPlane(const Cameraf& view) {
    const float perPixel = 1 / std::max(view.fx, view.fy);
    const Mat3f& r = view.viewFromWorldRotation;
    return {Vec3f(r[0][2], r[1][2], r[2][2]) * perPixel, view.viewFromWorldTranslation.z * perPixel};
}

/** What drawing wants of general splats, which may be a room around the camera: each half-chunk has its own pixel, where its box comes
 * nearest to the view that sees it finest. */
struct GeneralDetail {
    float perPixel = std::numeric_limits<float>::infinity();  // splats a pixel; infinite: all, exactly
    PixelPlane planes[2];
    float finestM = 0;  // no pixel counts as smaller
    bool full() const { return !(perPixel < std::numeric_limits<float>::infinity()); }

    /** Of a box: its middle and half its size. */
    float pixelM(const Vec3f& middle, const Vec3f& reach) const {
        float nearest = std::numeric_limits<float>::infinity();
        for (const PixelPlane& p : planes)
            nearest = std::min(nearest, glm::dot(p.axis, middle) + p.offsetM - glm::dot(glm::abs(p.axis), reach));
        return nearest > finestM ? nearest : finestM;
    }
};

/** Number within its half-chunk of the splat of a rank: bits in reverse, so that every prefix of the ranks is spread evenly over neighbours
 * (van der Corput). A half-chunk with fewer than 128 splats lacks some ranks. */
constexpr uint32_t placeOfRank(uint32_t rank) {
    uint32_t place = 0;
    for (uint32_t bit = 1; bit < kSplatGroupSize; bit <<= 1) place = place << 1 | (rank & bit ? 1u : 0u);
    return place;
}

/** Of a half-chunk whose splats stand for areaM2 each: the share that is kept whole. At least one splat. */
template <class T>
T keptShare(T perM2, T areaM2) {
    return std::clamp(perM2 * areaM2, T(1) / T(kSplatGroupSize), T(1));
}

/** Ranks that are drawn at all. */
template <class T>
uint32_t drawnRanks(T share) {
    return share >= 1 ? kSplatGroupSize
                      : std::min(kSplatGroupSize, uint32_t(std::ceil(share * T((1 + kDetailFade) * kSplatGroupSize) - T(0.5))));
}

/** Of its opacity, of the splat of a rank. */
template <class T>
T detailWeight(T share, uint32_t rank) {
    if (share >= 1) return 1;
    const T kept = share * T(kSplatGroupSize);
    return std::clamp((kept * T(1 + kDetailFade) - (T(rank) + T(0.5))) / (kept * T(kDetailFade)), T(0), T(1));
}

/** Factor of the standard deviations that keeps enough area covered; gain, enough: of SplatGroup. Splats lie many deep, so the first ones
 * to go leave no gap. */
template <class T>
T detailGrowth(T share, T gain, T enough) {
    return share >= 1 ? T(1) : std::sqrt(std::max(T(1), enough * std::pow(share, -gain)));
}

/** Of SH beyond coefficient 0, where so much of an avatar is kept. */
template <class T>
T detailShShare(T share) {
    return std::clamp((share - T(kDetailShGone)) / T(kDetailShFull - kDetailShGone), T(0), T(1));
}

}  // namespace dpl
