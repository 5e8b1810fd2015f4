// SPDX-License-Identifier: Apache-2.0
// Flat splats bound to triangles (docs/reference/binding.md): frames of triangles at rest and posed, and splats on them.
#pragma once

#include "sdk/math/formulas.h"

namespace dpl {

/** D⁻¹ = [i00 i01; 0 i11] of a rest triangle, 1/m. All zero for a degenerate triangle. */
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

/** Frame and D⁻¹ of a triangle at rest; corners in metres. With e1 = a1 − a0 and e2 = a2 − a0: T1 = e1/|e1|, N = e1×e2/|e1×e2|,
 *  T2 = N×T1, D = [e1·T1 e2·T1; 0 e2·T2]. Not valid where the area is too small or not finite. */
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

/** A posed triangle, as far as its splats need it. */
template <class T>
struct TriangleFrame {
    Vec3<T> v0, v1, v2;        // posed corners, world
    Vec3<T> f0, f1;            // columns of F: deformation gradient of the plane, no unit
    T shown = 1;               // opacity factor of its splats (drawnTriangle)
    bool bounded = false;      // drawnTriangle has changed F
    Vec3<T> normal;            // unit, world
    Mat3<T> worldFromRest{1};  // polar rotation: turns rest directions into the world
    Vec3<T> light{1};          // brightness at the three corners (docs/reference/correctives.md)
    bool valid = false;        // false: degenerate at rest or posed; its splats are not drawn
};

/** v0, v1, v2: posed corners, world. `light` of the result stays 1. */
template <class T>
inline TriangleFrame<T> poseTriangle(const RestTriangle<T>& rest, const Vec3<T>& v0, const Vec3<T>& v1, const Vec3<T>& v2) {
    TriangleFrame<T> f;
    f.v0 = v0, f.v1 = v1, f.v2 = v2;
    if (!rest.valid) return f;
    const auto posed = Formulas<T>::posedTriangle(rest.inverse.i00, rest.inverse.i01, rest.inverse.i11, v0, v1, v2);
    if (!posed.valid) return f;
    f.f0 = posed.f0, f.f1 = posed.f1, f.normal = posed.normal;
    f.worldFromRest = Mat3<T>(posed.turned1, posed.turned2, posed.normal) * glm::transpose(rest.frame);
    f.valid = true;
    return f;
}

/** M = [m00 m01; 0 m11] = D'·D⁻¹ maps the plane of a triangle at rest, `bind`, to that of the same triangle at another rest, `now`. So with
 *  F and F' measured from them, F = F'·M. */
template <class T>
struct RestMap {
    T m00, m01, m11;
    RestMap(const RestInverse<T>& bind, const RestInverse<T>& now)
        : m00(bind.i00 / now.i00), m01((bind.i01 - now.i01 * bind.i11 / now.i11) / now.i00), m11(bind.i11 / now.i11) {}
};

/** As poseTriangle(), with the stretch bounded and the opacity of an overstretched triangle faded, as pictures show it. Not valid where
 *  nothing is left of the opacity. Stretch is measured from `now`, the triangle at rest; splat sizes refer to `bind`, which differs from it
 *  while training moves the mesh. A triangle within the bounds is that of poseTriangle(), to the bit. */
template <class T>
inline TriangleFrame<T> drawnTriangle(const RestTriangle<T>& bind, const RestTriangle<T>& now, const Vec3<T>& v0, const Vec3<T>& v1,
                                      const Vec3<T>& v2) {
    using F = Formulas<T>;
    TriangleFrame<T> f = poseTriangle(bind, v0, v1, v2);
    if (!f.valid) return f;
    const RestInverse<T>&b = bind.inverse, &r = now.valid ? now.inverse : b;
    const auto posed = F::posedTriangle(r.i00, r.i01, r.i11, v0, v1, v2);
    const auto plane = F::boundedPlane(posed.f0, posed.f1, posed.turned1, posed.turned2);
    if (!plane.bounded) return f;
    const RestMap<T> m(b, r);
    f.f0 = m.m00 * plane.f0, f.f1 = m.m01 * plane.f0 + m.m11 * plane.f1;
    f.shown = plane.shown, f.bounded = true;
    f.valid = plane.shown > T(0);
    return f;
}
/** The same where splat sizes refer to the triangle at rest. */
template <class T>
inline TriangleFrame<T> drawnTriangle(const RestTriangle<T>& rest, const Vec3<T>& v0, const Vec3<T>& v1, const Vec3<T>& v2) {
    TriangleFrame<T> f = poseTriangle(rest, v0, v1, v2);
    if (!f.valid) return f;
    const auto plane = Formulas<T>::boundedPlane(f.f0, f.f1, f.worldFromRest * rest.frame[0], f.worldFromRest * rest.frame[1]);
    if (!plane.bounded) return f;
    f.f0 = plane.f0, f.f1 = plane.f1, f.shown = plane.shown, f.bounded = true;
    f.valid = plane.shown > T(0);
    return f;
}

/** World axes A1, A2 of a splat with in-plane angle phi (radians) and rest standard deviations s1, s2 (metres). */
template <class T>
inline void splatAxes(const TriangleFrame<T>& f, T phi, T s1, T s2, Vec3<T>& axis1, Vec3<T>& axis2) {
    const auto a = Formulas<T>::planeAxes(std::cos(phi), std::sin(phi), s1, s2);
    axis1 = a.a10 * f.f0 + a.a11 * f.f1;
    axis2 = a.a20 * f.f0 + a.a21 * f.f1;
}

/** World position of the barycentric point (1−u−v, u, v). */
template <class T>
inline Vec3<T> splatCentre(const TriangleFrame<T>& f, const Vec2<T>& uv) {
    return Formulas<T>::barycentric(f.v0, f.v1 - f.v0, f.v2 - f.v0, uv.x, uv.y);
}

/** Brightness at the barycentric point (1−u−v, u, v). */
template <class T>
inline T splatLight(const TriangleFrame<T>& f, const Vec2<T>& uv) {
    return Formulas<T>::barycentric(f.light.x, f.light.y - f.light.x, f.light.z - f.light.x, uv.x, uv.y);
}

}  // namespace dpl
