// SPDX-License-Identifier: Apache-2.0
// Light that stays in the world while the subject turns (docs/reference/light.md). Needs sh.inl.

/** Irradiance on a surface with the unit normal n, over its mean: c holds coefficients 1 to 8 of bands 1 and 2. */
DPL_FN real irradianceOn(real3 n, real3 c123, real3 c456, real2 c78) {
    ShBand1 a = shBand1(n);
    ShBand2 b = shBand2(n);
    real first = c123.x * a.b1 + c123.y * a.b2 + c123.z * a.b3;
    real second = c456.x * b.b4 + c456.y * b.b5 + c456.z * b.b6 + c78.x * b.b7 + c78.y * b.b8;
    return clamp(real(1) + first + second, real(kMinIrradiance), real(kMaxIrradiance));
}

/** A unit vector of the point e of the square [−1, 1]² that unfolds an octahedron (Cigolle et al. 2014). */
DPL_FN real3 fromOctahedron(real2 e) {
    real z = real(1) - abs(e.x) - abs(e.y), fold = max(-z, real(0));
    return normalize(real3(e.x + choose(e.x >= real(0), -fold, fold), e.y + choose(e.y >= real(0), -fold, fold), z));
}
