// SPDX-License-Identifier: Apache-2.0
// A posed triangle and its polar rotation (docs/reference/binding.md).

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
