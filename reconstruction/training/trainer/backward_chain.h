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

    TriangleGradient& operator+=(const TriangleGradient& o) {
        f0 += o.f0, f1 += o.f1, turn += o.turn, c0 += o.c0, c1 += o.c1, c2 += o.c2, light += o.light;
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
        const T gCos = g.opacity * splat.opacity * f.compensation * f.nearFade * smoothstep01Slope(f.cosine / T(kGateEnd)) / T(kGateEnd);
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

/** Corner gradients of a posed triangle from the sums over its splats. `rest` is the D⁻¹ that the triangle was posed with. The polar
 *  rotation P = worldFromRest·[T1 T2 N] is computed again from F and the normal n.
 *  A change δF turns the triangle's frame by  ω = n·(P2·δF0 − P1·δF1)/tr(PᵀF) + n×δn,  with δn = −Σ_k dual_k (n·δF_k). */
template <class T>
inline void finishTriangle(const TriangleFrame<T>& frame, const RestInverse<T>& rest, const TriangleGradient<T>& g, Vec3<T>& corner0,
                           Vec3<T>& corner1, Vec3<T>& corner2) {
    Vec3<T> gF0 = g.f0, gF1 = g.f1;
    const Vec3<T>& n = frame.normal;
    // Polar columns: for in-plane F, [P1 P2] ∝ [F0 + F1×n, F1 + n×F0] (F plus its cofactor; the determinant is positive here).
    Vec3<T> p1 = frame.f0 + glm::cross(frame.f1, n);
    const T length = glm::length(p1);
    if (length > T(1e-12)) {
        p1 /= length;
        const Vec3<T> p2 = glm::cross(n, p1);
        const T trace = glm::dot(p1, frame.f0) + glm::dot(p2, frame.f1);
        const T spin = glm::dot(g.turn, n) / trace;
        gF0 += spin * p2, gF1 -= spin * p1;
    }
    const T area = glm::dot(n, glm::cross(frame.f0, frame.f1));
    const Vec3<T> dual0 = glm::cross(frame.f1, n) / area, dual1 = glm::cross(n, frame.f0) / area;
    const Vec3<T> q = glm::cross(g.turn, n);
    gF0 -= glm::dot(q, dual0) * n, gF1 -= glm::dot(q, dual1) * n;
    const Vec3<T> gd1 = rest.i00 * gF0 + rest.i01 * gF1, gd2 = rest.i11 * gF1;
    corner0 = g.c0 - gd1 - gd2;
    corner1 = g.c1 + gd1;
    corner2 = g.c2 + gd2;
}

}  // namespace dpl
