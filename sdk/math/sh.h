// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics up to degree 3 in the order and sign of 3D Gaussian splatting files (docs/reference/spherical-harmonics.md).
#pragma once

#include "sdk/math/formulas.h"

namespace dpl {

constexpr uint32_t shCoefficientCount(uint32_t degree) {
    return (degree + 1) * (degree + 1);
}
constexpr uint32_t kMaxShDegree = 3;
constexpr uint32_t kMaxShCoefficients = 16;

/** Writes basis[0 .. (degree+1)²) for the unit direction d, which runs from the eye to the splat. */
template <class T>
inline void shBasis(const Vec3<T>& d, uint32_t degree, T* basis) {
    using F = Formulas<T>;
    basis[0] = T(kShC0);
    if (degree < 1) return;
    const auto one = F::shBand1(d);
    basis[1] = one.b1, basis[2] = one.b2, basis[3] = one.b3;
    if (degree < 2) return;
    const auto two = F::shBand2(d);
    basis[4] = two.b4, basis[5] = two.b5, basis[6] = two.b6, basis[7] = two.b7, basis[8] = two.b8;
    if (degree < 3) return;
    const auto three = F::shBand3(d);
    basis[9] = three.b9, basis[10] = three.b10, basis[11] = three.b11, basis[12] = three.b12, basis[13] = three.b13;
    basis[14] = three.b14, basis[15] = three.b15;
}

/** Display-referred colour (0.5 + Σ basis·sh)·light, clamped to [0,1]. sh: coefficient-major, sh[k*3 + channel]. */
template <class T>
inline Vec3<T> shColour(const T* sh, uint32_t degree, const Vec3<T>& d, T light = T(1)) {
    T basis[kMaxShCoefficients];
    shBasis(d, degree, basis);
    Vec3<T> c(T(0.5));
    for (uint32_t k = 0; k < shCoefficientCount(degree); ++k) c += basis[k] * Vec3<T>(sh[k * 3], sh[k * 3 + 1], sh[k * 3 + 2]);
    return glm::clamp(c * light, T(0), T(1));
}

}  // namespace dpl
