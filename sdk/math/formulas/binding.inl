// SPDX-License-Identifier: Apache-2.0
// Flat splats bound to triangles (docs/reference/binding.md). No 3×3 covariance is formed.
//
//   posed edges d1, d2:  F = [d1 d2]·D⁻¹, 3×2: the deformation gradient of the triangle's plane
//   splat:               axes [A1 A2] = F·R(φ)·diag(s1, s2), covariance A·Aᵀ, centre v0 + u·d1 + v·d2

/** Value at barycentric (1−u−v, u, v). origin: value at the first corner; step1, step2: differences of the other corners to it. */
DPL_FN real barycentric(real origin, real step1, real step2, real u, real v) {
    return origin + u * step1 + v * step2;
}
DPL_FN real3 barycentric(real3 origin, real3 step1, real3 step2, real u, real v) {
    return origin + u * step1 + v * step2;
}

/** R(φ)·diag(s1, s2), metres: the posed axes are A1 = a10·F0 + a11·F1 and A2 = a20·F0 + a21·F1. */
struct PlaneAxes {
    real a10;
    real a11;
    real a20;
    real a21;
};

/** cosine, sine: of φ. */
DPL_FN PlaneAxes planeAxes(real cosine, real sine, real scale1M, real scale2M) {
    PlaneAxes a;
    a.a10 = scale1M * cosine;
    a.a11 = scale1M * sine;
    a.a20 = -(scale2M * sine);
    a.a21 = scale2M * cosine;
    return a;
}
