// SPDX-License-Identifier: Apache-2.0
// A flat splat as a general Gaussian: its ellipse in the plane of its posed triangle, and the axes and covariance of that. Needs
// binding.inl.

/** Standard deviation of a flat splat across the surface, m: files hold its logarithm, which 0 has none of. */
DPL_FN real flatThicknessM() {
    return real(1e-4);
}

/** A·Aᵀ = [c11 c12; c12 c22] in orthonormal axes t1 and t2 of the plane, and det A. */
struct PlaneEllipse {
    real c11;
    real c12;
    real c22;
    real determinant;
};

/** f00 = t1·F0, f01 = t1·F1, f10 = t2·F0, f11 = t2·F1: F from the plane at rest to t1 and t2. */
DPL_FN PlaneEllipse planeEllipse(PlaneAxes a, real f00, real f01, real f10, real f11) {
    real x1 = a.a10 * f00 + a.a11 * f01, y1 = a.a10 * f10 + a.a11 * f11;
    real x2 = a.a20 * f00 + a.a21 * f01, y2 = a.a20 * f10 + a.a21 * f11;
    PlaneEllipse e;
    e.c11 = x1 * x1 + x2 * x2;
    e.c12 = x1 * y1 + x2 * y2;
    e.c22 = y1 * y1 + y2 * y2;
    e.determinant = (f00 * f11 - f01 * f10) * (a.a10 * a.a21 - a.a11 * a.a20);
    return e;
}

/** Standard deviations, the longer first, and cosine and sine of half the angle θ from t1 to the longer one; |θ| ≤ 90°. */
struct EllipseAxes {
    real major;
    real minor;
    real halfCosine;
    real halfSine;
};

DPL_FN EllipseAxes ellipseAxes(PlaneEllipse e) {
    // The larger eigenvalue is a sum; the smaller one follows from the determinant, so that needles do not cancel.
    real mean = real(0.5) * (e.c11 + e.c22), difference = real(0.5) * (e.c11 - e.c22);
    real radius = sqrt(difference * difference + e.c12 * e.c12);
    truth isRound = !(radius > real(0));
    EllipseAxes a;
    a.major = sqrt(mean + radius);
    a.minor = choose(a.major > real(0), abs(e.determinant) / a.major, real(0));
    // From the cosine and sine of 2θ those of θ, and of θ/2, without a difference of near numbers.
    real cosine2 = choose(isRound, real(1), difference / radius), sine2 = choose(isRound, real(0), e.c12 / radius);
    real larger = sqrt(real(0.5) * (real(1) + abs(cosine2))), smaller = real(0.5) * abs(sine2) / larger;
    real cosine = choose(cosine2 < real(0), smaller, larger), sine = choose(cosine2 < real(0), larger, smaller);
    a.halfCosine = sqrt(real(0.5) * (real(1) + cosine));
    a.halfSine = real(0.5) * choose(sine2 < real(0), -sine, sine) / a.halfCosine;
    return a;
}

/** One number of the 3×3 covariance: of the directions i and k, whose components along t1, t2 and the normal are x, y and n. across:
 *  variance along the normal. */
DPL_FN real ellipseCovariance(PlaneEllipse e, real across, real xi, real yi, real ni, real xk, real yk, real nk) {
    return e.c11 * xi * xk + e.c12 * (xi * yk + yi * xk) + e.c22 * yi * yk + across * ni * nk;
}

/** Coefficient 0 of spherical harmonics that have the light L of a splat in them: 0.5 + C₀·dc' + … = L·(0.5 + C₀·dc + …). The other
 *  coefficients are multiplied by L. */
DPL_FN real litCoefficient0(real dc, real light) {
    return light * dc + (light - real(1)) * real(0.5 / kShC0);
}
