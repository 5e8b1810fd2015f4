// SPDX-License-Identifier: Apache-2.0
// A posed triangle, its polar rotation, and bounds of its stretch (docs/reference/binding.md). Needs footprint.inl.

/** f0, f1: columns of F. normal: unit, world. Polar rotation: worldFromRest = [turned1 turned2 normal]·restFrameᵀ, where restFrame =
 *  [T1 T2 N] of the triangle at rest. */
struct PosedTriangle {
    real3 f0;
    real3 f1;
    real3 normal;
    real3 turned1;
    real3 turned2;
    truth valid;  // false: degenerate or not finite; the other fields may then hold anything
};

/** i00, i01, i11: D⁻¹ = [i00 i01; 0 i11] of the triangle at rest, 1/m. v0, v1, v2: posed corners, world. */
DPL_FN PosedTriangle posedTriangle(real i00, real i01, real i11, real3 v0, real3 v1, real3 v2) {
    PosedTriangle t;
    real3 d1 = v1 - v0, d2 = v2 - v0, d3 = v2 - v1;
    real3 area = cross(d1, d2);
    real doubleArea = length(area);
    real longest2 = max(dot(d1, d1), max(dot(d2, d2), dot(d3, d3)));
    t.valid = doubleArea > real(2.0 * kMinTriangleAreaM2) && longest2 < real(kMaxTriangleAspect) * doubleArea;
    t.f0 = d1 * i00;
    t.f1 = d1 * i01 + d2 * i11;
    t.normal = area / doubleArea;
    // Polar rotation of F as a 2×2 matrix m between the planes' frames. t1 runs along d1, so m10 = t2·F0 = 0.
    real3 t1 = normalize(d1), t2 = cross(t.normal, t1);
    real sine = -dot(t1, t.f1), cosine = dot(t1, t.f0) + dot(t2, t.f1);
    real radius = sqrt(sine * sine + cosine * cosine);
    real c = choose(radius > real(1e-12), cosine / radius, real(1)), s = choose(radius > real(1e-12), sine / radius, real(0));
    t.turned1 = c * t1 + s * t2;
    t.turned2 = c * t2 - s * t1;
    return t;
}

/** Singular value of F that is drawn instead of `stretch`. Its slope is 1 at both bounds, so drawn axes change smoothly. */
DPL_FN real boundedStretch(real stretch) {
    real over = max(stretch - real(kStretchHigh), real(0)), under = max(real(kStretchLow) - stretch, real(0));
    real within = clamp(stretch, real(kStretchLow), real(kStretchHigh));
    return within + over * real(kStretchHighRoom) / (real(kStretchHighRoom) + over) -
           under * real(kStretchLowRoom) / (real(kStretchLowRoom) + under);
}

/** Square root of the slope of boundedStretch(): 1 within the bounds. */
DPL_FN real stretchYield(real stretch) {
    real over = max(stretch - real(kStretchHigh), real(0)), under = max(real(kStretchLow) - stretch, real(0));
    return (real(kStretchHighRoom) / (real(kStretchHighRoom) + over)) * (real(kStretchLowRoom) / (real(kStretchLowRoom) + under));
}

/** Opacity factor of a singular value. A triangle's splats have the product of both, which is smooth where the two are equal. */
DPL_FN real shownStretch(real stretch) {
    return smoothstep01((real(kStretchGone) - stretch) * real(1.0 / (kStretchGone - kStretchFade))) *
           smoothstep01(stretch * real(1.0 / kSqueezeFade));
}

/** Singular values of F = [F0 F1], and its stretch in the frame [P1 P2] of its polar rotation: the symmetric matrix
 *  (largest + smallest)/2 + [difference mixed; mixed −difference], where gap = √(difference² + mixed²) = (largest − smallest)/2. */
struct PlaneStretch {
    real largest;
    real smallest;
    real gap;
    real difference;
    real mixed;
};

DPL_FN PlaneStretch planeStretch(real3 f0, real3 f1, real3 p1, real3 p2) {
    PlaneStretch s;
    real s00 = dot(p1, f0), s11 = dot(p2, f1);
    s.difference = real(0.5) * (s00 - s11);
    s.mixed = dot(p1, f1);
    s.gap = sqrt(s.difference * s.difference + s.mixed * s.mixed);
    s.largest = real(0.5) * (s00 + s11) + s.gap;
    s.smallest = dot(cross(p1, p2), cross(f0, f1)) / s.largest;  // by the determinant: a difference would cancel
    return s;
}

/** choose() by component: Metal has no choice between vectors by one truth value. */
DPL_FN real3 choose3(truth condition, real3 yes, real3 no) {
    return real3(choose(condition, yes.x, no.x), choose(condition, yes.y, no.y), choose(condition, yes.z, no.z));
}

/** F with its singular values within bounds. */
struct BoundedPlane {
    real3 f0;
    real3 f1;
    real shown;     // opacity factor
    truth bounded;  // false: f0 and f1 are those given and shown is 1, to the bit
};

/** p1, p2: columns of the polar rotation of F, P1 and P2 (turned1 and turned2 of a PosedTriangle). */
DPL_FN BoundedPlane boundedPlane(real3 f0, real3 f1, real3 p1, real3 p2) {
    PlaneStretch s = planeStretch(f0, f1, p1, p2);
    BoundedPlane b;
    b.bounded = s.largest > real(kStretchHigh) || s.smallest < real(kStretchLow);
    real largest = boundedStretch(s.largest), smallest = boundedStretch(s.smallest);
    real mean = real(0.5) * (largest + smallest);
    real share = choose(s.gap > real(1e-12), real(0.5) * (largest - smallest) / s.gap, real(0));
    real difference = share * s.difference, mixed = share * s.mixed;
    real3 bounded0 = (mean + difference) * p1 + mixed * p2, bounded1 = mixed * p1 + (mean - difference) * p2;
    b.f0 = choose3(b.bounded, bounded0, f0);
    b.f1 = choose3(b.bounded, bounded1, f1);
    b.shown = choose(b.bounded, shownStretch(s.largest) * shownStretch(s.smallest), real(1));
    return b;
}
