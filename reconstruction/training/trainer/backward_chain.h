// SPDX-License-Identifier: Apache-2.0
// Backward pass of one bound splat: from the gradient on its screen record to the gradients on its parameters and its triangle
// (docs/reference/binding.md, docs/reference/footprint.md). The trainer instantiates the templates in float, the gradient tests in double.
//
//   (x, y, conic, opacity', colour) ─► B, z ─► A1, A2, centre ─► (F, φ, ln s, u, v) and the triangle's corners
//
// The forward pass stores its intermediate values in a ForwardRecord, so nothing is projected a second time.
// Every path is differentiated, also those through the view direction (SH), the gate and the polar rotation. The gradient of a rigid
// motion of all vertices therefore equals that of the opposite camera motion. D⁻¹ of the rest triangle is a constant.
#pragma once

#include <algorithm>
#include <cmath>

#include "reconstruction/training/trainer/sh_backward.h"
#include "sdk/math/binding.h"
#include "sdk/math/projection.h"
#include "sdk/math/sh.h"
#include "sdk/splat/forward_record.h"

namespace dpl {

/** ∂loss/∂(screen record of one splat, as blending reads it). x, y in pixels; conicB is the coefficient of dx·dy; opacity is the effective
 *  opacity' = opacity · compensation · gate · nearFade. */
template <class T>
struct ScreenGradient {
    T x = 0, y = 0;
    T conicA = 0, conicB = 0, conicC = 0;
    T opacity = 0;
    Vec3<T> colour{0};
};

/** The parameters of one splat that the backward pass reads. `sh` is borrowed. */
template <class T>
struct SplatParameters {
    Vec2<T> uv{0};
    T opacity = 0;  // linear
    bool singleFace = false;
    uint32_t shDegree = 0;
    const T* sh = nullptr;  // coefficient-major
};

/** ∂loss/∂parameters of one splat. */
template <class T>
struct ParameterGradient {
    Vec2<T> uv{0};
    T phi = 0;
    Vec2<T> logScale{0};  // s·∂loss/∂s: no division, so it stays finite for tiny splats
    T opacity = 0;        // wrt the linear opacity
    T sh[kMaxShCoefficients * 3] = {};
};

/** Gradients summed over the splats of one triangle. finishTriangle() turns them into corner gradients. */
template <class T>
struct TriangleGradient {
    Vec3<T> f0{0}, f1{0};         // wrt the columns of F
    Vec3<T> turn{0};              // wrt an infinitesimal world rotation of the triangle's normal and polar rotation
    Vec3<T> c0{0}, c1{0}, c2{0};  // wrt the corners through splat centres
    Vec3<T> light{0};             // wrt the brightness at the corners
    T shown = 0;                  // wrt TriangleFrame::shown

    TriangleGradient& operator+=(const TriangleGradient& o) {
        f0 += o.f0, f1 += o.f1, turn += o.turn, c0 += o.c0, c1 += o.c1, c2 += o.c2, light += o.light, shown += o.shown;
        return *this;
    }
};

/** Camera constants of one view. */
template <class T>
struct ViewConstants {
    Lens<T> lens;
    Mat3<T> worldFromView;  // rotation

    explicit ViewConstants(const PinholeCamera<T>& c) : lens(lensOf(c)), worldFromView(glm::transpose(c.viewFromWorldRotation)) {}
};

/** Derivative of smoothstep01(). */
template <class T>
inline T smoothstep01Slope(T x) {
    return x > T(0) && x < T(1) ? T(6) * x * (T(1) - x) : T(0);
}

/** Backward pass of one splat that the forward pass drew. `f` is its forward record, `g` the gradient on its screen record. Overwrites
 *  `out` and adds to `triangle`. The colour clamp to [0, 1] passes gradients on unchanged, except those that would push a clamped colour
 *  further out. */
template <class T>
inline void backwardSplat(const ViewConstants<T>& view, const TriangleFrame<T>& frame, const SplatParameters<T>& splat,
                          const ForwardRecord<T>& f, const ScreenGradient<T>& g, ParameterGradient<T>& out, TriangleGradient<T>& triangle) {
    const Vec2<T> b1(f.b1X, f.b1Y), b2(f.b2X, f.b2Y);
    const T detB = Formulas<T>::determinantOf(b1, b2);
    const T jx = view.lens.focalPx.x * f.inverseZ, jy = view.lens.focalPx.y * f.inverseZ;
    const bool floored = !(f.compensation > T(kMinCompensation));

    // ---- opacity' = opacity · compensation · gate · nearFade ----
    out.opacity = g.opacity * f.compensation * f.gate * f.nearFade;
    const T gCompensation = floored ? T(0) : g.opacity * splat.opacity * f.gate * f.nearFade;
    const T gFade = g.opacity * splat.opacity * f.compensation * f.gate;
    triangle.shown += gFade * f.nearFade / frame.shown;

    // ---- conic Q -> Σ': dΣ = −Q G Q; compensation = |det B|/√det Σ' adds −½·g·comp·Q to dΣ and ±g·cof(B)/√det to dB ----
    const T qa = f.conicA, qb = f.conicB, qc = f.conicC;
    const T ga = g.conicA, gb = T(0.5) * g.conicB, gc = g.conicC;
    const T m00 = ga * qa + gb * qb, m01 = ga * qb + gb * qc, m10 = gb * qa + gc * qb, m11 = gb * qb + gc * qc;  // G·Q
    const T half = T(0.5) * gCompensation * f.compensation;
    const T s00 = -(qa * m00 + qb * m10) - half * qa;
    const T s01 = -(qa * m01 + qb * m11) - half * qb;
    const T s11 = -(qb * m01 + qc * m11) - half * qc;
    const T k = gCompensation * std::sqrt(f.inverseDet) * (detB < T(0) ? T(-1) : T(1));
    const Vec2<T> gB1(T(2) * (s00 * b1.x + s01 * b1.y) + k * b2.y, T(2) * (s01 * b1.x + s11 * b1.y) - k * b2.x);
    const Vec2<T> gB2(T(2) * (s00 * b2.x + s01 * b2.y) - k * b1.y, T(2) * (s01 * b2.x + s11 * b2.y) + k * b1.x);

    // ---- B -> view-space axes and centre ----
    const Vec3<T> ga1(jx * gB1.x, jy * gB1.y, -(jx * f.clampedX * gB1.x + jy * f.clampedY * gB1.y));
    const Vec3<T> ga2(jx * gB2.x, jy * gB2.y, -(jx * f.clampedX * gB2.x + jy * f.clampedY * gB2.y));
    Vec3<T> gView(0);
    gView.z = -(glm::dot(gB1, b1) + glm::dot(gB2, b2)) * f.inverseZ;  // J ∝ 1/z
    T gSlopeX = view.lens.focalPx.x * g.x, gSlopeY = view.lens.focalPx.y * g.y;
    if (f.slopeX > view.lens.minSlope.x && f.slopeX < view.lens.maxSlope.x) gSlopeX -= jx * (gB1.x * f.axis1Z + gB2.x * f.axis2Z);
    if (f.slopeY > view.lens.minSlope.y && f.slopeY < view.lens.maxSlope.y) gSlopeY -= jy * (gB1.y * f.axis1Z + gB2.y * f.axis2Z);
    gView.x = gSlopeX * f.inverseZ, gView.y = gSlopeY * f.inverseZ;
    gView.z -= (gSlopeX * f.slopeX + gSlopeY * f.slopeY) * f.inverseZ;
    constexpr T kPerFade = T(1 / (kNearFadeEndM - kNearM));
    gView.z += gFade * smoothstep01Slope((f.depthM - T(kNearM)) * kPerFade) * kPerFade;
    Vec3<T> gCentre = view.worldFromView * gView;
    const Vec3<T> gAxis1 = view.worldFromView * ga1, gAxis2 = view.worldFromView * ga2;

    // ---- gate ----
    const Vec3<T> dRest(f.directionX, f.directionY, f.directionZ), d = frame.worldFromRest * dRest;  // eye → splat, unit
    Vec3<T> turn(0);
    if (splat.singleFace) {
        const T gCos =
            g.opacity * splat.opacity * f.compensation * f.nearFade * frame.shown * smoothstep01Slope(f.cosine / T(kGateEnd)) / T(kGateEnd);
        if (gCos != T(0)) {
            gCentre -= gCos * (frame.normal + f.cosine * d) * f.inverseDistance;
            turn -= glm::cross(frame.normal, gCos * d);
        }
    }

    // ---- colour ----
    T gLight = 0;
    {
        T basis[kMaxShCoefficients], weight[kMaxShCoefficients] = {};
        shBasis(dRest, splat.shDegree, basis);
        const uint32_t count = shCoefficientCount(splat.shDegree);
        const Vec3<T> unlit(f.red, f.green, f.blue);
        Vec3<T> gColour = g.colour;
        for (int ch = 0; ch < 3; ++ch) {
            const T lit = unlit[ch] * f.light;
            if ((lit > T(1) && gColour[ch] < T(0)) || (lit < T(0) && gColour[ch] > T(0))) gColour[ch] = T(0);
            gLight += gColour[ch] * glm::max(unlit[ch], T(0));
        }
        gColour *= f.light;
        for (uint32_t i = 0; i < count; ++i) {
            for (int ch = 0; ch < 3; ++ch) out.sh[i * 3 + uint32_t(ch)] = basis[i] * gColour[ch];
            weight[i] = splat.sh[i * 3] * gColour.x + splat.sh[i * 3 + 1] * gColour.y + splat.sh[i * 3 + 2] * gColour.z;
        }
        if (splat.shDegree > 0) {
            const Vec3<T> gd = frame.worldFromRest * shBasisGradient(dRest, splat.shDegree, weight);
            gCentre += (gd - d * glm::dot(d, gd)) * f.inverseDistance;
            turn += glm::cross(gd, d);
        }
    }

    // ---- A -> F, φ, ln s; centre -> u, v ----
    const T on10 = glm::dot(gAxis1, frame.f0), on11 = glm::dot(gAxis1, frame.f1);
    const T on20 = glm::dot(gAxis2, frame.f0), on21 = glm::dot(gAxis2, frame.f1);
    out.logScale = {f.a10 * on10 + f.a11 * on11, f.a20 * on20 + f.a21 * on21};
    out.phi = f.a10 * on11 - f.a11 * on10 + f.a20 * on21 - f.a21 * on20;
    out.uv = {glm::dot(gCentre, frame.v1 - frame.v0) + gLight * (frame.light.y - frame.light.x),
              glm::dot(gCentre, frame.v2 - frame.v0) + gLight * (frame.light.z - frame.light.x)};
    triangle.f0 += f.a10 * gAxis1 + f.a20 * gAxis2, triangle.f1 += f.a11 * gAxis1 + f.a21 * gAxis2;
    triangle.turn += turn;
    triangle.light += gLight * Vec3<T>(T(1) - splat.uv.x - splat.uv.y, splat.uv.x, splat.uv.y);
    triangle.c0 += (T(1) - splat.uv.x - splat.uv.y) * gCentre;
    triangle.c1 += splat.uv.x * gCentre;
    triangle.c2 += splat.uv.y * gCentre;
}

/** Derivative of Formulas::shownStretch(). */
template <class T>
inline T shownStretchSlope(T stretch) {
    constexpr T kPerFade = T(1 / (kStretchGone - kStretchFade)), kPerSqueeze = T(1 / kSqueezeFade);
    return smoothstep01Slope(stretch * kPerSqueeze) * kPerSqueeze - smoothstep01Slope((T(kStretchGone) - stretch) * kPerFade) * kPerFade;
}

/** A gradient on the F of a plane, by columns. */
template <class T>
struct PlaneGradient {
    Vec3<T> f0{0}, f1{0};
};

/** Backward of Formulas::boundedPlane(): from a gradient on the bounded F and on `shown` to that on F = [f0 f1]. p1, p2: columns of its
 * polar rotation. With F = U diag(σ) Vᵀ, c = boundedStretch and G = [U n]ᵀ·gradient·V, the result is again [U n]·G'·Vᵀ with G'_kk = c'(σ_k)
 * G_kk,    G'_nk = c_k/σ_k G_nk, G'_12 ± G'_21 = (c1 ∓ c2)/(σ1 ∓ σ2) (G_12 ± G_21). */
template <class T>
inline PlaneGradient<T> boundedPlaneBackward(const Vec3<T>& f0, const Vec3<T>& f1, const Vec3<T>& p1, const Vec3<T>& p2,
                                             const PlaneGradient<T>& g, T gShown) {
    using F = Formulas<T>;
    const auto s = F::planeStretch(f0, f1, p1, p2);
    const Vec3<T> n = glm::cross(p1, p2);
    // V turns the rest plane by the angle of the larger stretch; U = P·V. Where both are equal any angle will do.
    T cosine = 1, sine = 0;
    if (s.gap > T(1e-12)) {
        const T angle = T(0.5) * std::atan2(s.mixed, s.difference);
        cosine = std::cos(angle), sine = std::sin(angle);
    }
    const Vec3<T> u1 = cosine * p1 + sine * p2, u2 = cosine * p2 - sine * p1;
    const Vec3<T> g1 = cosine * g.f0 + sine * g.f1, g2 = cosine * g.f1 - sine * g.f0;  // gradient·V
    const T c1 = F::boundedStretch(s.largest), c2 = F::boundedStretch(s.smallest);
    const T yield1 = F::stretchYield(s.largest), yield2 = F::stretchYield(s.smallest);
    // Of nearly equal stretches the quotient cancels. Both then lie on one side of a bound, where it is exactly the product.
    const T symmetric = s.gap > T(1e-3) * s.largest ? (c1 - c2) / (s.largest - s.smallest) : yield1 * yield2;
    const T antisymmetric = (c1 + c2) / (s.largest + s.smallest);
    const T even = T(0.5) * symmetric * (glm::dot(u1, g2) + glm::dot(u2, g1)),
            odd = T(0.5) * antisymmetric * (glm::dot(u1, g2) - glm::dot(u2, g1));
    T on1 = yield1 * yield1 * glm::dot(u1, g1), on2 = yield2 * yield2 * glm::dot(u2, g2);
    if (gShown != T(0)) {
        on1 += gShown * shownStretchSlope(s.largest) * F::shownStretch(s.smallest);
        on2 += gShown * shownStretchSlope(s.smallest) * F::shownStretch(s.largest);
    }
    const Vec3<T> out1 = on1 * u1 + (even - odd) * u2 + (c1 / s.largest * glm::dot(n, g1)) * n;
    const Vec3<T> out2 = (even + odd) * u1 + on2 * u2 + (c2 / s.smallest * glm::dot(n, g2)) * n;
    return {cosine * out1 - sine * out2, sine * out1 + cosine * out2};
}

/** Fills three corner gradients of a drawn triangle (drawnTriangle of bind and now) from the sums over its splats. D⁻¹ of both rest
 * triangles are constants. F before the bounds is computed again from the corners, and the polar rotation P = worldFromRest·[T1 T2 N] from
 * it and n. A change δF turns the triangle's frame by  ω = n·(P2·δF0 − P1·δF1)/tr(PᵀF) + n×δn,  with δn = −Σ_k dual_k (n·δF_k). */
template <class T>
inline void finishTriangle(const TriangleFrame<T>& frame, const RestTriangle<T>& bind, const RestTriangle<T>& now,
                           const TriangleGradient<T>& g, Vec3<T>* corner) {
    const RestInverse<T>& rest = bind.inverse;
    const Vec3<T>& n = frame.normal;
    Vec3<T> f0 = frame.f0, f1 = frame.f1, gF0 = g.f0, gF1 = g.f1, gd1(0), gd2(0);
    if (frame.bounded) {
        const RestInverse<T>& r = now.valid ? now.inverse : rest;
        const auto posed = Formulas<T>::posedTriangle(r.i00, r.i01, r.i11, frame.v0, frame.v1, frame.v2);
        const RestMap<T> m(rest, r);
        const auto stretch =
            boundedPlaneBackward<T>(posed.f0, posed.f1, posed.turned1, posed.turned2, {m.m00 * gF0 + m.m01 * gF1, m.m11 * gF1}, g.shown);
        gd1 = r.i00 * stretch.f0 + r.i01 * stretch.f1, gd2 = r.i11 * stretch.f1;
        const Vec3<T> d1 = frame.v1 - frame.v0, d2 = frame.v2 - frame.v0;
        f0 = rest.i00 * d1, f1 = rest.i01 * d1 + rest.i11 * d2;
        gF0 = gF1 = Vec3<T>(0);
    }
    // Polar columns: for in-plane F, [P1 P2] ∝ [F0 + F1×n, F1 + n×F0] (F plus its cofactor; the determinant is positive here).
    Vec3<T> p1 = f0 + glm::cross(f1, n);
    const T length = glm::length(p1);
    if (length > T(1e-12)) {
        p1 /= length;
        const Vec3<T> p2 = glm::cross(n, p1);
        const T trace = glm::dot(p1, f0) + glm::dot(p2, f1);
        const T spin = glm::dot(g.turn, n) / trace;
        gF0 += spin * p2, gF1 -= spin * p1;
    }
    const T area = glm::dot(n, glm::cross(f0, f1));
    const Vec3<T> dual0 = glm::cross(f1, n) / area, dual1 = glm::cross(n, f0) / area;
    const Vec3<T> q = glm::cross(g.turn, n);
    gF0 -= glm::dot(q, dual0) * n, gF1 -= glm::dot(q, dual1) * n;
    if (frame.bounded)
        gd1 += rest.i00 * gF0 + rest.i01 * gF1, gd2 += rest.i11 * gF1;
    else
        gd1 = rest.i00 * gF0 + rest.i01 * gF1, gd2 = rest.i11 * gF1;
    corner[0] = g.c0 - gd1 - gd2;
    corner[1] = g.c1 + gd1;
    corner[2] = g.c2 + gd2;
}

}  // namespace dpl
