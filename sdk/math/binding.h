// SPDX-License-Identifier: Apache-2.0
// Flat splats bound to triangles (technical reference §5.1): no 3×3 covariance is ever formed.
//
//   rest triangle (a0,a1,a2): T1 = e1/|e1|, n = e1×e2/|e1×e2|, T2 = n×T1, D = [e1·T1 e2·T1; 0 e2·T2]
//   posed edges d1,d2:        F = [d1 d2] D⁻¹  (3×2, the deformation gradient of the plane)
//   splat:                    A = F·R(φ)·diag(s1,s2), covariance A·Aᵀ, centre b0 v0 + u v1 + v v2 with b0 = 1−u−v
#pragma once

#include <cmath>

#include "sdk/math/types.h"

namespace dpl {

constexpr double kMinTriangleAreaM2 = 1e-10;  // faces below this carry no splats
constexpr double kMaxTriangleAspect = 1e4;    // longest edge² / (2·area) of a posed face; splats of worse faces are skipped

/** D⁻¹ = [i00 i01; 0 i11] of a rest triangle, metres⁻¹. All zero for a degenerate triangle. */
template <class T>
struct RestInverse {
    T i00 = 0, i01 = 0, i11 = 0;
};

/** Orthonormal rest frame [T1 T2 N] of a triangle as columns, and D⁻¹. `valid` is false below kMinTriangleAreaM2. */
template <class T>
struct RestTriangle {
    Mat3<T> frame{1};
    RestInverse<T> inverse;
    bool valid = false;
};

template <class T>
inline RestTriangle<T> restTriangle(const Vec3<T>& a0, const Vec3<T>& a1, const Vec3<T>& a2) {
    RestTriangle<T> r;
    const Vec3<T> e1 = a1 - a0, e2 = a2 - a0;
    const Vec3<T> cross = glm::cross(e1, e2);
    const T length1 = glm::length(e1), doubleArea = glm::length(cross);
    if (!(doubleArea > T(2 * kMinTriangleAreaM2)) || !(length1 > T(0)) || !std::isfinite(doubleArea)) return r;
    const Vec3<T> t1 = e1 / length1, n = cross / doubleArea, t2 = glm::cross(n, t1);
    const T d00 = length1, d01 = glm::dot(e2, t1), d11 = glm::dot(e2, t2);
    r.frame = Mat3<T>(t1, t2, n);
    r.inverse = {T(1) / d00, -d01 / (d00 * d11), T(1) / d11};
    r.valid = true;
    return r;
}

/** The posed side of one triangle: all that its splats need. */
template <class T>
struct TriangleFrame {
    Vec3<T> v0, v1, v2;        // posed corners, world
    Vec3<T> f0, f1;            // columns of F
    Vec3<T> normal;            // unit, world
    Mat3<T> worldFromRest{1};  // polar rotation of the triangle: turns rest directions into the world
    Vec3<T> light{1};          // brightness L at the three corners (reference §7)
    bool valid = false;        // false: degenerate at rest or posed, draw nothing
};

template <class T>
inline TriangleFrame<T> poseTriangle(const RestTriangle<T>& rest, const Vec3<T>& v0, const Vec3<T>& v1, const Vec3<T>& v2) {
    TriangleFrame<T> f;
    f.v0 = v0, f.v1 = v1, f.v2 = v2;
    if (!rest.valid) return f;
    const Vec3<T> d1 = v1 - v0, d2 = v2 - v0, d3 = v2 - v1;
    const Vec3<T> cross = glm::cross(d1, d2);
    const T doubleArea = glm::length(cross);
    const T longest2 = glm::max(glm::dot(d1, d1), glm::max(glm::dot(d2, d2), glm::dot(d3, d3)));
    if (!(doubleArea > T(2 * kMinTriangleAreaM2)) || !(longest2 < T(kMaxTriangleAspect) * doubleArea)) return f;
    f.f0 = d1 * rest.inverse.i00;
    f.f1 = d1 * rest.inverse.i01 + d2 * rest.inverse.i11;
    f.normal = cross / doubleArea;
    // Polar rotation of the 2×2 map between the frames. t1 runs along d1, so m10 = t2·F0 = 0.
    const Vec3<T> t1 = glm::normalize(d1), t2 = glm::cross(f.normal, t1);
    const T m00 = glm::dot(t1, f.f0), m01 = glm::dot(t1, f.f1), m11 = glm::dot(t2, f.f1);
    const T sine = -m01, cosine = m00 + m11;
    const T radius = std::sqrt(sine * sine + cosine * cosine);
    const T c = radius > T(1e-12) ? cosine / radius : T(1), s = radius > T(1e-12) ? sine / radius : T(0);
    const Mat3<T> posed(c * t1 + s * t2, c * t2 - s * t1, f.normal);  // [t1 t2 n]·rot
    f.worldFromRest = posed * glm::transpose(rest.frame);
    f.valid = true;
    return f;
}

/** World axes A1, A2 of a splat with in-plane angle phi (radians) and rest standard deviations s1, s2 (metres). */
template <class T>
inline void splatAxes(const TriangleFrame<T>& f, T phi, T s1, T s2, Vec3<T>& axis1, Vec3<T>& axis2) {
    const T c = std::cos(phi), s = std::sin(phi);
    axis1 = s1 * (c * f.f0 + s * f.f1);
    axis2 = s2 * (c * f.f1 - s * f.f0);
}

template <class T>
inline Vec3<T> splatCentre(const TriangleFrame<T>& f, const Vec2<T>& uv) {
    return (T(1) - uv.x - uv.y) * f.v0 + uv.x * f.v1 + uv.y * f.v2;
}

/** Brightness at a splat: L of the corners, barycentric. */
template <class T>
inline T splatLight(const TriangleFrame<T>& f, const Vec2<T>& uv) {
    return f.light.x + uv.x * (f.light.y - f.light.x) + uv.y * (f.light.z - f.light.x);
}

}  // namespace dpl
