// SPDX-License-Identifier: Apache-2.0
// Derivatives of the SH basis of sdk/math/sh.h.
#pragma once

#include "sdk/math/sh.h"

namespace dpl {

/** Σ_k weight[k] · ∂basis[k]/∂d at the unit direction d. The basis is differentiated as a polynomial in (x, y, z), so the caller removes
 *  the component along d. */
template <class T>
inline Vec3<T> shBasisGradient(const Vec3<T>& d, uint32_t degree, const T* weight) {
    const T x = d.x, y = d.y, z = d.z;
    Vec3<T> g(0);
    if (degree < 1) return g;
    constexpr T c1 = T(0.4886025119029199);
    g += Vec3<T>(-c1 * weight[3], -c1 * weight[1], c1 * weight[2]);
    if (degree < 2) return g;
    constexpr T k2 = T(1.0925484305920792), k0 = T(0.31539156525252005), k4 = T(0.5462742152960396);
    g += weight[4] * k2 * Vec3<T>(y, x, 0);
    g -= weight[5] * k2 * Vec3<T>(0, z, y);
    g += weight[6] * k0 * Vec3<T>(-2 * x, -2 * y, 4 * z);
    g -= weight[7] * k2 * Vec3<T>(z, 0, x);
    g += weight[8] * k4 * Vec3<T>(2 * x, -2 * y, 0);
    if (degree < 3) return g;
    constexpr T e = T(-0.5900435899266435), f = T(2.890611442640554), h = T(-0.4570457994644658), i = T(0.3731763325901154),
                j = T(1.445305721320277);
    const T xx = x * x, yy = y * y, zz = z * z, xy = x * y, yz = y * z, xz = x * z;
    g += weight[9] * e * Vec3<T>(6 * xy, 3 * (xx - yy), 0);
    g += weight[10] * f * Vec3<T>(yz, xz, xy);
    g += weight[11] * h * Vec3<T>(-2 * xy, 4 * zz - xx - 3 * yy, 8 * yz);
    g += weight[12] * i * Vec3<T>(-6 * xz, -6 * yz, 6 * zz - 3 * xx - 3 * yy);
    g += weight[13] * h * Vec3<T>(4 * zz - 3 * xx - yy, -2 * xy, 8 * xz);
    g += weight[14] * j * Vec3<T>(2 * xz, -2 * yz, xx - yy);
    g += weight[15] * e * Vec3<T>(3 * (xx - yy), -6 * xy, 0);
    return g;
}

}  // namespace dpl
