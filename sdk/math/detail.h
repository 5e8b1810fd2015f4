// SPDX-License-Identifier: Apache-2.0
// Level of detail (docs/reference/level-of-detail.md): which splats of a group are drawn when its surface covers few pixels, with which
// opacity, and how much they grow. The formulas are in sdk/math/formulas/detail.inl, which the shaders compile too.
//
//   splats wanted per m² ─► share of the group ─► weight of each splat by its rank ─► opacity · weight, scale · growth
//
// Everything is continuous in the wanted density, so nothing pops while a camera moves.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sdk/math/camera.h"
#include "sdk/math/formulas.h"

namespace dpl {

constexpr uint32_t kSplatGroupSize = 128;  // group: splats [0, 128) or [128, 256) of a chunk
static_assert(kSplatGroupSize == uint32_t(kDetailGroup));
constexpr double kDetailThrough = 0.02;                        // extra share of light that the kept splats may let through before they grow
constexpr double kDetailShFull = 0.25, kDetailShGone = 0.125;  // SH bands above 0 fade between these kept shares of an avatar's splats

/** How much of one avatar is drawn. */
struct SplatDetail {
    float perM2 = std::numeric_limits<float>::infinity();  // wanted splats per m² of surface at rest; infinite: all, unchanged
    float shShare = 1;                                     // factor of SH coefficients above band 0
    bool full() const { return !(perM2 < std::numeric_limits<float>::infinity()); }
};

/** Size of a view's pixel at a world point, metres: dot(axis, point) + offsetM. */
struct PixelPlane {
    Vec3f axis{0};  // world, no unit
    float offsetM = 0;
};

inline PixelPlane pixelPlane(const Cameraf& view) {
    const float perPixel = 1 / std::max(view.fx, view.fy);
    const Mat3f& r = view.viewFromWorldRotation;
    return {Vec3f(r[0][2], r[1][2], r[2][2]) * perPixel, view.viewFromWorldTranslation.z * perPixel};
}

/** How much of a set of general splats is drawn. The set may be a room around the camera, so each group has its own pixel size: the
 *  smallest over the views, at the point of the group's box nearest to the view. */
struct GeneralDetail {
    float perPixel = std::numeric_limits<float>::infinity();  // wanted splats per pixel; infinite: all, unchanged
    PixelPlane planes[2];                                     // one a view; the same twice for one view
    float finestM = 0;                                        // lower bound of the pixel size, m
    bool full() const { return !(perPixel < std::numeric_limits<float>::infinity()); }

    /** Pixel size of a box, m. middle: world; reach: half its size, m. */
    float pixelM(const Vec3f& middle, const Vec3f& reach) const {
        float nearest = std::numeric_limits<float>::infinity();
        for (const PixelPlane& p : planes) nearest = std::min(nearest, Formulas<float>::nearestPixelM(p.axis, p.offsetM, middle, reach));
        return nearest > finestM ? nearest : finestM;
    }
};

/** Index within its group of the splat with this rank, both 0 to 127. */
inline uint32_t placeOfRank(uint32_t rank) {
    return Formulas<float>::placeOfRank(rank);
}

/** Share of a group whose splats keep their full opacity, at least one splat. areaM2: surface that each splat stands for, m². */
template <class T>
T keptShare(T perM2, T areaM2) {
    return Formulas<T>::keptShare(perM2 * areaM2);
}

/** Ranks [0, n) have a weight above 0. */
template <class T>
uint32_t drawnRanks(T share) {
    return share >= 1 ? kSplatGroupSize
                      : std::min(kSplatGroupSize, uint32_t(std::ceil(share * T((1 + kDetailFade) * kSplatGroupSize) - T(0.5))));
}

/** Opacity factor of the splat with this rank. */
template <class T>
T detailWeight(T share, uint32_t rank) {
    return Formulas<T>::detailWeight(share, rank);
}

/** Factor of the standard deviations of the kept splats, ≥ 1. gain, enough: of SplatGroup. Trained splats lie several deep, so growth
 *  starts only when what is left covers too little. */
template <class T>
T detailGrowth(T share, T gain, T enough) {
    return Formulas<T>::detailGrowth(share, gain, enough);
}

/** Factor of SH coefficients above band 0 when this share of an avatar's splats is kept. */
template <class T>
T detailShShare(T share) {
    return std::clamp((share - T(kDetailShGone)) / T(kDetailShFull - kDetailShGone), T(0), T(1));
}

}  // namespace dpl
