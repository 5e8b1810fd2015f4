// SPDX-License-Identifier: Apache-2.0
// Screen footprint of a flat splat (docs/reference/projection.md, docs/reference/footprint.md): wraps sdk/math/formulas/footprint.inl,
// which trainer, CPU renderer and GPU renderer compile.
//
//   α(pixel) = min(0.99, opacity'·exp(−σ)), dropped below 1/255. When a pixel stops blending: sdk/splat/splat_engine.h.
#pragma once

#include "sdk/math/camera.h"
#include "sdk/math/formulas.h"

namespace dpl {

constexpr double kKappaPx2 = 0.3;  // low-pass variance where a file has none, px² of the target

template <class T>
using Lens = typename Formulas<T>::Lens;
template <class T>
using Footprint = typename Formulas<T>::Footprint;

template <class T>
inline T smoothstep01(T x) {
    return Formulas<T>::smoothstep01(x);
}

/** Opacity factor of a single-face splat: 0 from behind, 1 from cosθ = kGateEnd on, cosθ = n·(eye−c)/|eye−c|. All in world space. */
template <class T>
inline T singleFaceGate(const Vec3<T>& normal, const Vec3<T>& centre, const Vec3<T>& eye) {
    const Vec3<T> toEye = eye - centre;
    return Formulas<T>::singleFaceGate(glm::dot(normal, toEye), glm::length(toEye));
}

/** Opacity factor at view z: 0 up to kNearM, 1 from kNearFadeEndM on. */
template <class T>
inline T nearFade(T depthM) {
    return Formulas<T>::nearFade(depthM);
}

/** Limits of x/z and y/z for the Jacobian: the image widened by kClampMargin·tan(half field of view) on each side. */
template <class T>
struct JacobianClamp {
    T minX, maxX, minY, maxY;
    explicit JacobianClamp(const PinholeCamera<T>& c) {
        const T marginX = T(kClampMargin) * T(c.widthPx) / (T(2) * c.fx), marginY = T(kClampMargin) * T(c.heightPx) / (T(2) * c.fy);
        minX = -c.cx / c.fx - marginX;
        maxX = (T(c.widthPx) - c.cx) / c.fx + marginX;
        minY = -c.cy / c.fy - marginY;
        maxY = (T(c.heightPx) - c.cy) / c.fy + marginY;
    }
};

template <class T>
inline Lens<T> lensOf(const PinholeCamera<T>& c) {
    const JacobianClamp<T> limit(c);
    return {{c.fx, c.fy}, {c.cx, c.cy}, {limit.minX, limit.minY}, {limit.maxX, limit.maxY}};
}

/** Projects a flat splat: centre and axes in view space, metres; κ in px² of the target. */
template <class T>
inline Footprint<T> projectSplat(const Lens<T>& lens, const Vec3<T>& centreView, const Vec3<T>& axis1View, const Vec3<T>& axis2View,
                                 T kappaPx2) {
    return Formulas<T>::projectFlat(lens, centreView, axis1View, axis2View, kappaPx2);
}

/** Squared Mahalanobis radius q at which opacity·exp(−q/2) falls to kMinAlpha; negative when the splat is invisible. */
template <class T>
inline T visibleRadius2(T opacity) {
    return Formulas<T>::visibleRadius2(opacity);
}

}  // namespace dpl
