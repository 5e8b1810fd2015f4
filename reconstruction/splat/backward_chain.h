// SPDX-License-Identifier: Apache-2.0
// Backward of one bound splat: gradient on its screen record -> its parameters and its triangle (technical reference §5.1, §17).
// Templates: the trainer runs them in float, the gradient tests in double.
//
//   (x, y, conic, opacity', colour) ─► B, z ─► A1, A2, centre ─► (F, φ, ln s, u, v) and the triangle's corners
//
// Every path is differentiated, those through the view direction (SH), the gate and the polar rotation included, so that moving
// all vertices rigidly is exactly the same as moving the camera. D⁻¹ of the rest triangle is a constant.
#pragma once

#include <algorithm>
#include <cmath>

#include "reconstruction/splat/sh_backward.h"
#include "sdk/math/binding.h"
#include "sdk/math/projection.h"
#include "sdk/math/sh.h"

namespace dpl {

/** ∂loss/∂(what blending reads of one splat). conicB is the coefficient of dx·dy, opacity the effective one. */
template <class T>
struct ScreenGradient {
    T x = 0, y = 0;
    T conicA = 0, conicB = 0, conicC = 0;
    T opacity = 0;
    Vec3<T> colour{0};
};

/** What one splat is, borrowed for the call. */
template <class T>
struct SplatParameters {
    Vec2<T> uv{0};
    T phi = 0;
    Vec2<T> scaleM{0};
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

/** Sums over the splats of one triangle; finished into corner gradients by finishTriangle(). */
template <class T>
struct TriangleGradient {
    Vec3<T> f0{0}, f1{0};         // wrt the columns of F
    Vec3<T> turn{0};              // wrt an infinitesimal world rotation of the triangle's frame (normal and polar rotation)
    Vec3<T> c0{0}, c1{0}, c2{0};  // wrt the corners through splat centres
    Vec3<T> light{0};             // wrt the brightness at the corners

    TriangleGradient& operator+=(const TriangleGradient& o) {
        f0 += o.f0, f1 += o.f1, turn += o.turn, c0 += o.c0, c1 += o.c1, c2 += o.c2, light += o.light;
        return *this;
    }
};

/** One view as the chain needs it. */
template <class T>
struct ViewConstants {
    PinholeCamera<T> camera;
    JacobianClamp<T> limit;
    Vec3<T> eye;
    T kappaPx2;

    ViewConstants(const PinholeCamera<T>& c, T kappa) : camera(c), limit(c), eye(c.eye()), kappaPx2(kappa) {}
};

/** d smoothstep01 / dx. */
template <class T>
inline T smoothstep01Slope(T x) {
    return x > T(0) && x < T(1) ? T(6) * x * (T(1) - x) : T(0);
}

/** Backward of one splat that projectSplat() found visible. Adds into `triangle`; overwrites `out`.
 *  The colour clamp passes gradients straight through, except those that would push a clamped colour further out. */
template <class T>
inline void backwardSplat(const ViewConstants<T>& view, const TriangleFrame<T>& frame, const SplatParameters<T>& splat,
                          const ScreenGradient<T>& g, ParameterGradient<T>& out, TriangleGradient<T>& triangle) {
    const PinholeCamera<T>& cam = view.camera;
    const Mat3<T>& viewR = cam.viewFromWorldRotation;
    // ---- forward, as projectSplat() does it ----
    const Vec3<T> centre = splatCentre(frame, splat.uv);
    const T cosPhi = std::cos(splat.phi), sinPhi = std::sin(splat.phi);
    const Vec3<T> axis1 = splat.scaleM.x * (cosPhi * frame.f0 + sinPhi * frame.f1);
    const Vec3<T> axis2 = splat.scaleM.y * (cosPhi * frame.f1 - sinPhi * frame.f0);
    const Vec3<T> c = cam.toView(centre), a1 = viewR * axis1, a2 = viewR * axis2;
    const T invZ = T(1) / c.z;
    const T slopeX = c.x * invZ, slopeY = c.y * invZ;
    const T jx = cam.fx * invZ, jy = cam.fy * invZ;
    const T sx = glm::clamp(slopeX, view.limit.minX, view.limit.maxX), sy = glm::clamp(slopeY, view.limit.minY, view.limit.maxY);
    const T b00 = jx * (a1.x - sx * a1.z), b01 = jx * (a2.x - sx * a2.z);
    const T b10 = jy * (a1.y - sy * a1.z), b11 = jy * (a2.y - sy * a2.z);
    const T varX = b00 * b00 + b01 * b01 + view.kappaPx2, varY = b10 * b10 + b11 * b11 + view.kappaPx2;
    const T cov = b00 * b10 + b01 * b11, detB = b00 * b11 - b01 * b10;
    const T det = detB * detB + view.kappaPx2 * (varX + varY - view.kappaPx2);
    const T invDet = T(1) / det;
    const T qa = varY * invDet, qb = -cov * invDet, qc = varX * invDet;  // Q = Σ'⁻¹ = [qa qb; qb qc]
    const T rawCompensation = std::abs(detB) * std::sqrt(invDet);
    const bool floored = !(rawCompensation > T(kMinCompensation));
    const T compensation = floored ? T(kMinCompensation) : rawCompensation;
    const T fadeArgument = (c.z - T(kNearM)) / T(kNearFadeEndM - kNearM);
    const T fade = smoothstep01(fadeArgument);
    const Vec3<T> toEye = view.eye - centre;
    const T distance = glm::length(toEye);
    const T cosTheta = glm::dot(frame.normal, toEye) / distance;
    const T gate = splat.singleFace ? smoothstep01(cosTheta / T(kGateEnd)) : T(1);

    // ---- opacity' = opacity · compensation · gate · fade ----
    out.opacity = g.opacity * compensation * gate * fade;
    const T gCompensation = floored ? T(0) : g.opacity * splat.opacity * gate * fade;
    const T gFade = g.opacity * splat.opacity * compensation * gate;

    // ---- conic -> Σ': dΣ = −Q G Q; compensation = |det B|/√det Σ' adds −½·g·comp·Q to dΣ and ±g·cof(B)/√det to dB ----
    const T ga = g.conicA, gb = T(0.5) * g.conicB, gc = g.conicC;
    const T m00 = ga * qa + gb * qb, m01 = ga * qb + gb * qc, m10 = gb * qa + gc * qb, m11 = gb * qb + gc * qc;  // G·Q
    const T half = T(0.5) * gCompensation * compensation;
    const T s00 = -(qa * m00 + qb * m10) - half * qa;
    const T s01 = -(qa * m01 + qb * m11) - half * qb;
    const T s11 = -(qb * m01 + qc * m11) - half * qc;
    const T k = gCompensation * std::sqrt(invDet) * (detB < T(0) ? T(-1) : T(1));
    const T g00 = T(2) * (s00 * b00 + s01 * b10) + k * b11;
    const T g01 = T(2) * (s00 * b01 + s01 * b11) - k * b10;
    const T g10 = T(2) * (s01 * b00 + s11 * b10) - k * b01;
    const T g11 = T(2) * (s01 * b01 + s11 * b11) + k * b00;

    // ---- B -> view-space axes and centre ----
    const Vec3<T> ga1(jx * g00, jy * g10, -(jx * sx * g00 + jy * sy * g10));
    const Vec3<T> ga2(jx * g01, jy * g11, -(jx * sx * g01 + jy * sy * g11));
    Vec3<T> gView(0);
    gView.z = -(g00 * b00 + g01 * b01 + g10 * b10 + g11 * b11) * invZ;  // J ∝ 1/z
    T gSlopeX = cam.fx * g.x, gSlopeY = cam.fy * g.y;
    if (slopeX > view.limit.minX && slopeX < view.limit.maxX) gSlopeX -= jx * (g00 * a1.z + g01 * a2.z);
    if (slopeY > view.limit.minY && slopeY < view.limit.maxY) gSlopeY -= jy * (g10 * a1.z + g11 * a2.z);
    gView.x = gSlopeX * invZ, gView.y = gSlopeY * invZ;
    gView.z -= (gSlopeX * slopeX + gSlopeY * slopeY) * invZ;
    gView.z += gFade * smoothstep01Slope(fadeArgument) / T(kNearFadeEndM - kNearM);
    const Mat3<T> worldR = glm::transpose(viewR);
    Vec3<T> gCentre = worldR * gView;
    const Vec3<T> gAxis1 = worldR * ga1, gAxis2 = worldR * ga2;

    // ---- gate ----
    Vec3<T> turn(0);
    if (splat.singleFace) {
        const T gCos = g.opacity * splat.opacity * compensation * fade * smoothstep01Slope(cosTheta / T(kGateEnd)) / T(kGateEnd);
        if (gCos != T(0)) {
            const Vec3<T> unit = toEye / distance;
            gCentre -= gCos * (frame.normal - cosTheta * unit) / distance;
            turn += glm::cross(frame.normal, gCos * unit);
        }
    }

    // ---- colour ----
    T gLight = 0;
    {
        const Vec3<T> d = -toEye / distance;
        const Vec3<T> dRest = glm::transpose(frame.worldFromRest) * d;
        T basis[kMaxShCoefficients], weight[kMaxShCoefficients] = {};
        shBasis(dRest, splat.shDegree, basis);
        const uint32_t count = shCoefficientCount(splat.shDegree);
        const T light = splatLight(frame, splat.uv);
        Vec3<T> colour(T(0.5)), gColour = g.colour;
        for (uint32_t i = 0; i < count; ++i) colour += basis[i] * Vec3<T>(splat.sh[i * 3], splat.sh[i * 3 + 1], splat.sh[i * 3 + 2]);
        for (int ch = 0; ch < 3; ++ch) {
            const T lit = colour[ch] * light;
            if ((lit > T(1) && gColour[ch] < T(0)) || (lit < T(0) && gColour[ch] > T(0))) gColour[ch] = T(0);
            gLight += gColour[ch] * glm::max(colour[ch], T(0));
        }
        gColour *= light;
        for (uint32_t i = 0; i < count; ++i) {
            for (int ch = 0; ch < 3; ++ch) out.sh[i * 3 + uint32_t(ch)] = basis[i] * gColour[ch];
            weight[i] = splat.sh[i * 3] * gColour.x + splat.sh[i * 3 + 1] * gColour.y + splat.sh[i * 3 + 2] * gColour.z;
        }
        if (splat.shDegree > 0) {
            const Vec3<T> gd = frame.worldFromRest * shBasisGradient(dRest, splat.shDegree, weight);
            gCentre += (gd - d * glm::dot(d, gd)) / distance;
            turn += glm::cross(gd, d);
        }
    }

    // ---- A -> F, φ, ln s; centre -> u, v ----
    out.logScale = {glm::dot(gAxis1, axis1), glm::dot(gAxis2, axis2)};
    const T c1 = splat.scaleM.x * cosPhi, s1 = splat.scaleM.x * sinPhi, c2 = splat.scaleM.y * cosPhi, s2 = splat.scaleM.y * sinPhi;
    const Vec3<T> gF0 = c1 * gAxis1 - s2 * gAxis2, gF1 = s1 * gAxis1 + c2 * gAxis2;
    out.phi = glm::dot(gAxis1, c1 * frame.f1 - s1 * frame.f0) - glm::dot(gAxis2, c2 * frame.f0 + s2 * frame.f1);
    out.uv = {glm::dot(gCentre, frame.v1 - frame.v0) + gLight * (frame.light.y - frame.light.x),
              glm::dot(gCentre, frame.v2 - frame.v0) + gLight * (frame.light.z - frame.light.x)};
    triangle.light += gLight * Vec3<T>(T(1) - splat.uv.x - splat.uv.y, splat.uv.x, splat.uv.y);
    triangle.f0 += gF0, triangle.f1 += gF1, triangle.turn += turn;
    triangle.c0 += (T(1) - splat.uv.x - splat.uv.y) * gCentre;
    triangle.c1 += splat.uv.x * gCentre;
    triangle.c2 += splat.uv.y * gCentre;
}

/** Corner gradients of a posed triangle from the sums of its splats. `rest` is the D⁻¹ it was posed with; the polar rotation is
 *  P = worldFromRest·[T1 T2 N], found again from F and the normal.
 *  A frame turn ω of the polar rotation is  ω = n·(P2·δF0 − P1·δF1)/tr(PᵀF) + n×δn,  δn = −Σ_k dual_k (n·δF_k). */
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
