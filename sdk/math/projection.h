// SPDX-License-Identifier: Apache-2.0
// Screen footprint of a flat splat (technical reference §5.5, §17): the same rule in trainer, software and Vulkan renderer.
//
//   B = J_p·W·A (2×2),  Σ' = B·Bᵀ + κI,  det Σ' = det(B)² + κ‖B‖² + κ²   (sum form: a·c−b² loses needles in float)
//   opacity' = opacity · compensation · gate · nearFade,  compensation = max(0.005, √(det(B)²/det Σ'))
//   α(pixel) = min(0.99, opacity'·exp(−σ)), dropped below 1/255;  an entry is blended while T > 1e-4 (so the one that
//   brings T to ≤ 1e-4 still counts: a renderer that stops later or never differs by < 1e-4; see sdk/splat/splat_engine.h)
#pragma once

#include <cmath>

#include "sdk/math/camera.h"

namespace dpl {

constexpr double kKappaPx2 = 0.3;  // low-pass variance where nothing else is said, target pixels²; avatars say theirs
constexpr double kMaxAlpha = 0.99;
constexpr double kMinAlpha = 1.0 / 255.0;
constexpr double kMinTransmittance = 1e-4;
constexpr double kMinCompensation = 0.005;
constexpr double kNearM = 0.05;         // splats whose centre is nearer are not drawn
constexpr double kNearFadeEndM = 0.15;  // ... and fade in up to here
constexpr double kClampMargin = 0.3;    // x/z is clamped to the image widened by this fraction of its half field of view
constexpr double kGateEnd = 0.1;        // single-face splats fade in over cosθ in [0, kGateEnd]

template <class T>
inline T smoothstep01(T x) {
    x = glm::clamp(x, T(0), T(1));
    return x * x * (T(3) - T(2) * x);
}

/** Opacity factor of a single-face splat: 0 from behind, 1 above cosθ = 0.1, with cosθ = n·(eye−c)/|eye−c|. */
template <class T>
inline T singleFaceGate(const Vec3<T>& normal, const Vec3<T>& centre, const Vec3<T>& eye) {
    const Vec3<T> toEye = eye - centre;
    return smoothstep01(glm::dot(normal, toEye) / (glm::length(toEye) * T(kGateEnd)));
}

template <class T>
inline T nearFade(T depthM) {
    return smoothstep01((depthM - T(kNearM)) / T(kNearFadeEndM - kNearM));
}

/** What one splat looks like in one view before colour. */
template <class T>
struct Footprint {
    Vec2<T> centrePx{0};
    T conicA = 0, conicB = 0, conicC = 0;  // σ = ½(A dx² + C dy²) + B dx dy
    T varianceX = 0, varianceY = 0;        // diagonal of Σ', px²: the box of level q is ±√(q·variance)
    T compensation = 0;
    T depthM = 0;          // view z
    bool visible = false;  // false: behind the near plane or not finite
};

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

/** Projects a flat splat: centre and axes in view space, κ in target pixels². */
template <class T>
inline Footprint<T> projectSplat(const PinholeCamera<T>& camera, const JacobianClamp<T>& limit, const Vec3<T>& centreView,
                                 const Vec3<T>& axis1View, const Vec3<T>& axis2View, T kappaPx2) {
    Footprint<T> f;
    f.depthM = centreView.z;
    if (!(centreView.z > T(kNearM))) return f;
    const T invZ = T(1) / centreView.z;
    const T slopeX = centreView.x * invZ, slopeY = centreView.y * invZ;
    f.centrePx = {camera.fx * slopeX + camera.cx, camera.fy * slopeY + camera.cy};
    const T jx = camera.fx * invZ, jy = camera.fy * invZ;
    const T sx = glm::clamp(slopeX, limit.minX, limit.maxX), sy = glm::clamp(slopeY, limit.minY, limit.maxY);
    const T b00 = jx * (axis1View.x - sx * axis1View.z), b01 = jx * (axis2View.x - sx * axis2View.z);
    const T b10 = jy * (axis1View.y - sy * axis1View.z), b11 = jy * (axis2View.y - sy * axis2View.z);
    f.varianceX = b00 * b00 + b01 * b01 + kappaPx2;
    f.varianceY = b10 * b10 + b11 * b11 + kappaPx2;
    const T covariance = b00 * b10 + b01 * b11;
    const T detB = b00 * b11 - b01 * b10;
    const T normB2 = b00 * b00 + b01 * b01 + b10 * b10 + b11 * b11;
    const T det = detB * detB + kappaPx2 * normB2 + kappaPx2 * kappaPx2;
    if (!(det > T(0)) || !std::isfinite(det)) return f;
    const T invDet = T(1) / det;
    f.conicA = f.varianceY * invDet;
    f.conicB = -covariance * invDet;
    f.conicC = f.varianceX * invDet;
    f.compensation = glm::max(T(kMinCompensation), std::sqrt(detB * detB * invDet));
    f.visible = std::isfinite(f.centrePx.x) && std::isfinite(f.centrePx.y);
    return f;
}

/** Squared Mahalanobis radius at which opacity·exp(−q/2) falls to kMinAlpha; negative when the splat is invisible. */
template <class T>
inline T visibleRadius2(T opacity) {
    return T(2) * std::log(opacity / T(kMinAlpha));
}

}  // namespace dpl
