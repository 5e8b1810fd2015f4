// SPDX-License-Identifier: Apache-2.0
// Backward formulas of a bound splat and of its triangle, for the trainer on the CPU (backward_chain.h, float and double) and its kernels
// (shaders/training). Rules of the subset: sdk/math/formulas/README.md, except that a `truth` is one value, which may be branched on.
// Needs binding.inl, footprint.inl and pose.inl; ForwardRecord, TriangleFrame and real33 (a 3×3 matrix by columns) as the includer names
// them. References: docs/reference/binding.md, docs/reference/footprint.md.

/** Derivative of smoothstep01(). */
DPL_FN real smoothstep01Slope(real x) {
    return x > real(0) && x < real(1) ? real(6) * x * (real(1) - x) : real(0);
}

/** Gradient on what blending reads of a splat, without its colour. x, y in pixels; conicB is the coefficient of dx·dy; opacity is the
 *  effective opacity' = opacity · compensation · gate · nearFade. */
struct FootprintGradient {
    real x;
    real y;
    real conicA;
    real conicB;
    real conicC;
    real opacity;
};

/** From the moments of the gradient g_σ on the exponent σ about the splat's centre: α = opacity'·exp(−σ),
 *  σ = ½(A dx² + C dy²) + B dx dy, dx = pixel − centre. */
DPL_FN FootprintGradient footprintGradient(real conicA, real conicB, real conicC, real opacity, real s, real sx, real sy, real sxx, real sxy,
                                           real syy) {
    FootprintGradient g;
    g.x = -(conicA * sx + conicB * sy);
    g.y = -(conicB * sx + conicC * sy);
    g.conicA = real(0.5) * sxx;
    g.conicB = sxy;
    g.conicC = real(0.5) * syy;
    g.opacity = opacity > real(0) ? -s / opacity : real(0);
    return g;
}

/** Camera constants of one view. */
struct BackwardView {
    Lens lens;
    real33 worldFromView;  // rotation
};

/** Gradients on the centre and the axes of a splat in the world. turn: wrt an infinitesimal world rotation of the triangle's normal and
 *  polar rotation. */
struct WorldGradient {
    real3 centre;
    real3 axis1;
    real3 axis2;
    real3 turn;
    real opacity;  // wrt the linear opacity
    real shown;    // wrt TriangleFrame.shown
};

/** Footprint -> centre and axes. splatOpacity: linear. */
DPL_FN WorldGradient footprintBackward(BackwardView view, TriangleFrame frame, real splatOpacity, truth singleFace, ForwardRecord f,
                                       FootprintGradient g) {
    WorldGradient w;
    real2 b1 = real2(f.b1X, f.b1Y), b2 = real2(f.b2X, f.b2Y);
    real detB = determinantOf(b1, b2);
    real jx = view.lens.focalPx.x * f.inverseZ, jy = view.lens.focalPx.y * f.inverseZ;
    truth floored = !(f.compensation > real(kMinCompensation));

    // ---- opacity' = opacity · compensation · gate · nearFade ----
    w.opacity = g.opacity * f.compensation * f.gate * f.nearFade;
    real gCompensation = floored ? real(0) : g.opacity * splatOpacity * f.gate * f.nearFade;
    real gFade = g.opacity * splatOpacity * f.compensation * f.gate;
    w.shown = gFade * f.nearFade / frame.shown;

    // ---- conic Q -> Σ': dΣ = −Q G Q; compensation = |det B|/√det Σ' adds −½·g·comp·Q to dΣ and ±g·cof(B)/√det to dB ----
    real qa = f.conicA, qb = f.conicB, qc = f.conicC;
    real ga = g.conicA, gb = real(0.5) * g.conicB, gc = g.conicC;
    real m00 = ga * qa + gb * qb, m01 = ga * qb + gb * qc, m10 = gb * qa + gc * qb, m11 = gb * qb + gc * qc;  // G·Q
    real half_ = real(0.5) * gCompensation * f.compensation;
    real s00 = -(qa * m00 + qb * m10) - half_ * qa;
    real s01 = -(qa * m01 + qb * m11) - half_ * qb;
    real s11 = -(qb * m01 + qc * m11) - half_ * qc;
    real k = gCompensation * sqrt(f.inverseDet) * (detB < real(0) ? real(-1) : real(1));
    real2 gB1 = real2(real(2) * (s00 * b1.x + s01 * b1.y) + k * b2.y, real(2) * (s01 * b1.x + s11 * b1.y) - k * b2.x);
    real2 gB2 = real2(real(2) * (s00 * b2.x + s01 * b2.y) - k * b1.y, real(2) * (s01 * b2.x + s11 * b2.y) + k * b1.x);

    // ---- B -> view-space axes and centre ----
    real3 ga1 = real3(jx * gB1.x, jy * gB1.y, -(jx * f.clampedX * gB1.x + jy * f.clampedY * gB1.y));
    real3 ga2 = real3(jx * gB2.x, jy * gB2.y, -(jx * f.clampedX * gB2.x + jy * f.clampedY * gB2.y));
    real3 gView = real3(real(0), real(0), -(dot(gB1, b1) + dot(gB2, b2)) * f.inverseZ);  // J ∝ 1/z
    real gSlopeX = view.lens.focalPx.x * g.x, gSlopeY = view.lens.focalPx.y * g.y;
    if (f.slopeX > view.lens.minSlope.x && f.slopeX < view.lens.maxSlope.x) gSlopeX -= jx * (gB1.x * f.axis1Z + gB2.x * f.axis2Z);
    if (f.slopeY > view.lens.minSlope.y && f.slopeY < view.lens.maxSlope.y) gSlopeY -= jy * (gB1.y * f.axis1Z + gB2.y * f.axis2Z);
    gView.x = gSlopeX * f.inverseZ;
    gView.y = gSlopeY * f.inverseZ;
    gView.z -= (gSlopeX * f.slopeX + gSlopeY * f.slopeY) * f.inverseZ;
    real perFade = real(1.0 / (kNearFadeEndM - kNearM));
    gView.z += gFade * smoothstep01Slope((f.depthM - real(kNearM)) * perFade) * perFade;
    w.centre = view.worldFromView * gView;
    w.axis1 = view.worldFromView * ga1;
    w.axis2 = view.worldFromView * ga2;

    // ---- gate ----
    w.turn = real3(real(0), real(0), real(0));
    if (singleFace) {
        real3 d = frame.worldFromRest * real3(f.directionX, f.directionY, f.directionZ);  // eye → splat, unit
        real gCos = g.opacity * splatOpacity * f.compensation * f.nearFade * frame.shown * smoothstep01Slope(f.cosine / real(kGateEnd)) /
                    real(kGateEnd);
        if (gCos != real(0)) {
            w.centre -= gCos * (frame.normal + f.cosine * d) * f.inverseDistance;
            w.turn -= cross(frame.normal, gCos * d);
        }
    }
    return w;
}

/** Gradients on the colour 0.5 + Σ basis·sh before brightness, and on the brightness. */
struct ColourGradient {
    real3 unlit;
    real light;
};

/** Gradient of one channel on clamp(unlit · light, 0, 1). It passes the clamp unchanged, except where it would push a clamped colour
 *  further out. */
DPL_FN real clampedColourGradient(real lit, real g) {
    return (lit > real(1) && g < real(0)) || (lit < real(0) && g > real(0)) ? real(0) : g;
}

DPL_FN ColourGradient colourBackward(ForwardRecord f, real3 g) {
    real3 passed = real3(clampedColourGradient(f.red * f.light, g.x), clampedColourGradient(f.green * f.light, g.y),
                         clampedColourGradient(f.blue * f.light, g.z));
    ColourGradient c;
    c.light = passed.x * max(f.red, real(0));
    c.light += passed.y * max(f.green, real(0));
    c.light += passed.z * max(f.blue, real(0));
    c.unlit = passed * f.light;
    return c;
}

/** Adds what SH above band 0 hear of the direction. gRest: gradient on the direction in the rest frame, not yet made tangent to it. */
DPL_FN WorldGradient directionBackward(WorldGradient w, TriangleFrame frame, ForwardRecord f, real3 gRest) {
    real3 d = frame.worldFromRest * real3(f.directionX, f.directionY, f.directionZ);
    real3 gd = frame.worldFromRest * gRest;
    w.centre += (gd - d * dot(d, gd)) * f.inverseDistance;
    w.turn += cross(gd, d);
    return w;
}

/** Gradients on the placement of a splat in its triangle. logScale: s·∂/∂s, without a division, so it stays finite for tiny splats. */
struct PlacementGradient {
    real2 uv;
    real phi;
    real2 logScale;
};

DPL_FN PlacementGradient placementBackward(TriangleFrame frame, ForwardRecord f, WorldGradient w, real gLight) {
    real on10 = dot(w.axis1, frame.f0), on11 = dot(w.axis1, frame.f1);
    real on20 = dot(w.axis2, frame.f0), on21 = dot(w.axis2, frame.f1);
    PlacementGradient p;
    p.logScale = real2(f.a10 * on10 + f.a11 * on11, f.a20 * on20 + f.a21 * on21);
    p.phi = f.a10 * on11 - f.a11 * on10 + f.a20 * on21 - f.a21 * on20;
    p.uv = real2(dot(w.centre, frame.v1 - frame.v0) + gLight * (frame.light.y - frame.light.x),
                 dot(w.centre, frame.v2 - frame.v0) + gLight * (frame.light.z - frame.light.x));
    return p;
}

/** Derivative of shownStretch(). */
DPL_FN real shownStretchSlope(real stretch) {
    real perFade = real(1.0 / (kStretchGone - kStretchFade)), perSqueeze = real(1.0 / kSqueezeFade);
    return smoothstep01Slope(stretch * perSqueeze) * perSqueeze - smoothstep01Slope((real(kStretchGone) - stretch) * perFade) * perFade;
}

/** A gradient on the F of a plane, by columns. */
struct PlaneGradient {
    real3 f0;
    real3 f1;
};

/** Backward of boundedPlane(): from a gradient on the bounded F and on `shown` to that on F = [f0 f1]. p1, p2: columns of its polar
 *  rotation. With F = U diag(σ) Vᵀ, c = boundedStretch and G = [U n]ᵀ·gradient·V, the result is again [U n]·G'·Vᵀ with
 *  G'_kk = c'(σ_k) G_kk,    G'_nk = c_k/σ_k G_nk, G'_12 ± G'_21 = (c1 ∓ c2)/(σ1 ∓ σ2) (G_12 ± G_21). */
DPL_FN PlaneGradient boundedPlaneBackward(real3 f0, real3 f1, real3 p1, real3 p2, PlaneGradient g, real gShown) {
    PlaneStretch s = planeStretch(f0, f1, p1, p2);
    real3 n = cross(p1, p2);
    // V turns the rest plane by the angle of the larger stretch; U = P·V. Where both are equal any angle will do.
    real cosine = real(1), sine = real(0);
    if (s.gap > real(1e-12)) {
        real angle = real(0.5) * atan2(s.mixed, s.difference);
        cosine = cos(angle);
        sine = sin(angle);
    }
    real3 u1 = cosine * p1 + sine * p2, u2 = cosine * p2 - sine * p1;
    real3 g1 = cosine * g.f0 + sine * g.f1, g2 = cosine * g.f1 - sine * g.f0;  // gradient·V
    real c1 = boundedStretch(s.largest), c2 = boundedStretch(s.smallest);
    real yield1 = stretchYield(s.largest), yield2 = stretchYield(s.smallest);
    // Of nearly equal stretches the quotient cancels. Both then lie on one side of a bound, where it is exactly the product.
    real symmetric = s.gap > real(1e-3) * s.largest ? (c1 - c2) / (s.largest - s.smallest) : yield1 * yield2;
    real antisymmetric = (c1 + c2) / (s.largest + s.smallest);
    real even = real(0.5) * symmetric * (dot(u1, g2) + dot(u2, g1)), odd = real(0.5) * antisymmetric * (dot(u1, g2) - dot(u2, g1));
    real on1 = yield1 * yield1 * dot(u1, g1), on2 = yield2 * yield2 * dot(u2, g2);
    if (gShown != real(0)) {
        on1 += gShown * shownStretchSlope(s.largest) * shownStretch(s.smallest);
        on2 += gShown * shownStretchSlope(s.smallest) * shownStretch(s.largest);
    }
    real3 out1 = on1 * u1 + (even - odd) * u2 + (c1 / s.largest * dot(n, g1)) * n;
    real3 out2 = (even + odd) * u1 + on2 * u2 + (c2 / s.smallest * dot(n, g2)) * n;
    PlaneGradient r;
    r.f0 = cosine * out1 - sine * out2;
    r.f1 = sine * out1 + cosine * out2;
    return r;
}

/** D⁻¹ = [i00 i01; 0 i11] of a triangle at rest, 1/m. */
struct RestEdges {
    real i00;
    real i01;
    real i11;
};

/** Gradients on the corners of a triangle through F and its rotation. */
struct EdgeGradient {
    real3 d1;  // wrt v1 − v0
    real3 d2;  // wrt v2 − v0
};

/** From the sums over the splats of a triangle to its edges. frame: a drawn triangle of bind and now; g: wrt the columns of its F; gTurn:
 *  WorldGradient.turn. D⁻¹ of both rest triangles are constants. F before the bounds is computed again from the corners, and the polar
 *  rotation P = worldFromRest·[T1 T2 N] from it and n. A change δF turns the triangle's frame by
 *  ω = n·(P2·δF0 − P1·δF1)/tr(PᵀF) + n×δn,  with δn = −Σ_k dual_k (n·δF_k). */
DPL_FN EdgeGradient triangleBackward(TriangleFrame frame, RestEdges bind, RestEdges now, PlaneGradient g, real3 gTurn, real gShown) {
    real3 n = frame.normal;
    real3 f0 = frame.f0, f1 = frame.f1, gF0 = g.f0, gF1 = g.f1;
    EdgeGradient edges;
    edges.d1 = real3(real(0), real(0), real(0));
    edges.d2 = real3(real(0), real(0), real(0));
    if (frame.bounded) {
        PosedTriangle posed = posedTriangle(now.i00, now.i01, now.i11, frame.v0, frame.v1, frame.v2);
        // M = [m00 m01; 0 m11] = D'·D⁻¹ from `bind` to `now`: F = F'·M.
        real m00 = bind.i00 / now.i00, m01 = (bind.i01 - now.i01 * bind.i11 / now.i11) / now.i00, m11 = bind.i11 / now.i11;
        PlaneGradient drawn;
        drawn.f0 = m00 * gF0 + m01 * gF1;
        drawn.f1 = m11 * gF1;
        PlaneGradient stretch = boundedPlaneBackward(posed.f0, posed.f1, posed.turned1, posed.turned2, drawn, gShown);
        edges.d1 = now.i00 * stretch.f0 + now.i01 * stretch.f1;
        edges.d2 = now.i11 * stretch.f1;
        real3 d1 = frame.v1 - frame.v0, d2 = frame.v2 - frame.v0;
        f0 = bind.i00 * d1;
        f1 = bind.i01 * d1 + bind.i11 * d2;
        gF0 = real3(real(0), real(0), real(0));
        gF1 = gF0;
    }
    // Polar columns: for in-plane F, [P1 P2] ∝ [F0 + F1×n, F1 + n×F0] (F plus its cofactor; the determinant is positive here).
    real3 p1 = f0 + cross(f1, n);
    real lengthOfP1 = length(p1);
    if (lengthOfP1 > real(1e-12)) {
        p1 /= lengthOfP1;
        real3 p2 = cross(n, p1);
        real trace = dot(p1, f0) + dot(p2, f1);
        real spin = dot(gTurn, n) / trace;
        gF0 += spin * p2;
        gF1 -= spin * p1;
    }
    real area = dot(n, cross(f0, f1));
    real3 dual0 = cross(f1, n) / area, dual1 = cross(n, f0) / area;
    real3 q = cross(gTurn, n);
    gF0 -= dot(q, dual0) * n;
    gF1 -= dot(q, dual1) * n;
    if (frame.bounded) {
        edges.d1 += bind.i00 * gF0 + bind.i01 * gF1;
        edges.d2 += bind.i11 * gF1;
    } else {
        edges.d1 = bind.i00 * gF0 + bind.i01 * gF1;
        edges.d2 = bind.i11 * gF1;
    }
    return edges;
}

/** Σ_k weight_k · ∂basis_k/∂d of one band of spherical harmonics (sh.inl). The basis is differentiated as a polynomial in (x, y, z), so the
 *  caller removes the component along d. */
DPL_FN real3 shBand1Gradient(ShBand1 w) {
    return real3(real(-kShC1) * w.b3, real(-kShC1) * w.b1, real(kShC1) * w.b2);
}
DPL_FN real3 shBand2Gradient(real3 d, ShBand2 w) {
    real k2 = real(1.0925484305920792), k0 = real(0.31539156525252005), k4 = real(0.5462742152960396);
    real3 g = w.b4 * k2 * real3(d.y, d.x, real(0));
    g -= w.b5 * k2 * real3(real(0), d.z, d.y);
    g += w.b6 * k0 * real3(real(-2) * d.x, real(-2) * d.y, real(4) * d.z);
    g -= w.b7 * k2 * real3(d.z, real(0), d.x);
    g += w.b8 * k4 * real3(real(2) * d.x, real(-2) * d.y, real(0));
    return g;
}
DPL_FN real3 shBand3Gradient(real3 d, ShBand3 w) {
    real e = real(-0.5900435899266435), f = real(2.890611442640554), h = real(-0.4570457994644658), i = real(0.3731763325901154),
         j = real(1.445305721320277);
    real xx = d.x * d.x, yy = d.y * d.y, zz = d.z * d.z, xy = d.x * d.y, yz = d.y * d.z, xz = d.x * d.z;
    real3 g = w.b9 * e * real3(real(6) * xy, real(3) * (xx - yy), real(0));
    g += w.b10 * f * real3(yz, xz, xy);
    g += w.b11 * h * real3(real(-2) * xy, real(4) * zz - xx - real(3) * yy, real(8) * yz);
    g += w.b12 * i * real3(real(-6) * xz, real(-6) * yz, real(6) * zz - real(3) * xx - real(3) * yy);
    g += w.b13 * h * real3(real(4) * zz - real(3) * xx - yy, real(-2) * xy, real(8) * xz);
    g += w.b14 * j * real3(real(2) * xz, real(-2) * yz, xx - yy);
    g += w.b15 * e * real3(real(3) * (xx - yy), real(-6) * xy, real(0));
    return g;
}
