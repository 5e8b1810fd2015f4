// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics up to degree 3 in the order and sign of 3D Gaussian splatting files (technical reference §1).
#pragma once

#include "sdk/math/types.h"

namespace dpl {

constexpr uint32_t shCoefficientCount(uint32_t degree) {
    return (degree + 1) * (degree + 1);
}
constexpr uint32_t kMaxShDegree = 3;
constexpr uint32_t kMaxShCoefficients = 16;
constexpr double kShC0 = 0.28209479177387814;

/** basis[0 .. (degree+1)²): values for the unit direction d (from the eye to the splat). */
template <class T>
inline void shBasis(const Vec3<T>& d, uint32_t degree, T* basis) {
    const T x = d.x, y = d.y, z = d.z;
    basis[0] = T(kShC0);
    if (degree < 1) return;
    constexpr double c1 = 0.4886025119029199;
    basis[1] = T(-c1) * y;
    basis[2] = T(c1) * z;
    basis[3] = T(-c1) * x;
    if (degree < 2) return;
    const T xx = x * x, yy = y * y, zz = z * z, xy = x * y, yz = y * z, xz = x * z;
    basis[4] = T(1.0925484305920792) * xy;
    basis[5] = T(-1.0925484305920792) * yz;
    basis[6] = T(0.31539156525252005) * (T(2) * zz - xx - yy);
    basis[7] = T(-1.0925484305920792) * xz;
    basis[8] = T(0.5462742152960396) * (xx - yy);
    if (degree < 3) return;
    basis[9] = T(-0.5900435899266435) * y * (T(3) * xx - yy);
    basis[10] = T(2.890611442640554) * xy * z;
    basis[11] = T(-0.4570457994644658) * y * (T(4) * zz - xx - yy);
    basis[12] = T(0.3731763325901154) * z * (T(2) * zz - T(3) * xx - T(3) * yy);
    basis[13] = T(-0.4570457994644658) * x * (T(4) * zz - xx - yy);
    basis[14] = T(1.445305721320277) * z * (xx - yy);
    basis[15] = T(-0.5900435899266435) * x * (xx - T(3) * yy);
}

/** (0.5 + Σ basis·sh)·light, clamped to [0,1]. sh: coefficient-major, sh[k*3 + channel]. Display-referred colour. */
template <class T>
inline Vec3<T> shColour(const T* sh, uint32_t degree, const Vec3<T>& d, T light = T(1)) {
    T basis[kMaxShCoefficients];
    shBasis(d, degree, basis);
    Vec3<T> c(T(0.5));
    for (uint32_t k = 0; k < shCoefficientCount(degree); ++k) c += basis[k] * Vec3<T>(sh[k * 3], sh[k * 3 + 1], sh[k * 3 + 2]);
    return glm::clamp(c * light, T(0), T(1));
}

}  // namespace dpl
