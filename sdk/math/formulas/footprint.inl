// SPDX-License-Identifier: Apache-2.0
// Screen footprint of a splat: docs/reference/projection.md, docs/reference/footprint.md, docs/reference/gate.md.
//
//   centre, axes (view space) ─► Jacobian J ─► b = J·axis, px ─► B·Bᵀ ─► Σ' = B·Bᵀ + κI ─► conic Σ'⁻¹, compensation
//   opacity' = opacity · compensation · gate · nearFade

DPL_FN real smoothstep01(real x) {
    x = clamp(x, real(0), real(1));
    return x * x * (real(3) - real(2) * x);
}

/** Opacity factor of a splat at view z: 0 up to kNearM, 1 from kNearFadeEndM on. */
DPL_FN real nearFade(real depthM) {
    return smoothstep01((depthM - real(kNearM)) * real(1.0 / (kNearFadeEndM - kNearM)));
}

/** Opacity factor of a single-face splat: 0 from behind, 1 from cosθ = kGateEnd on. planeDot: n·(eye − centre), m; distanceM: |eye −
 *  centre|. */
DPL_FN real singleFaceGate(real planeDot, real distanceM) {
    return smoothstep01(planeDot / (distanceM * real(kGateEnd)));
}

/** False for NaN too. */
DPL_FN truth isFinite(real x) {
    return abs(x) < real(3.0e38);
}

/** Pinhole projection of one view. minSlope, maxSlope: limits of x/z and y/z in the Jacobian (kClampMargin). */
struct Lens {
    real2 focalPx;
    real2 centrePx;
    real2 minSlope;
    real2 maxSlope;
};

/** Derivative of the projection at a view-space point: component k of J·a is pxPerM.k · (a.k − clampedSlope.k · a.z). */
struct Jacobian {
    real inverseZ;
    real2 slope;  // x/z, y/z
    real2 clampedSlope;
    real2 pxPerM;
};

DPL_FN Jacobian jacobianAt(Lens lens, real3 centre) {
    Jacobian j;
    j.inverseZ = real(1) / centre.z;
    j.slope = real2(centre.x * j.inverseZ, centre.y * j.inverseZ);
    j.clampedSlope = real2(clamp(j.slope.x, lens.minSlope.x, lens.maxSlope.x), clamp(j.slope.y, lens.minSlope.y, lens.maxSlope.y));
    j.pxPerM = real2(lens.focalPx.x * j.inverseZ, lens.focalPx.y * j.inverseZ);
    return j;
}

/** Image position, px, of the point that `j` was made for. */
DPL_FN real2 centreOnScreen(Lens lens, Jacobian j) {
    return real2(lens.focalPx.x * j.slope.x + lens.centrePx.x, lens.focalPx.y * j.slope.y + lens.centrePx.y);
}

/** J·axis, px. */
DPL_FN real2 axisOnScreen(Jacobian j, real3 axis) {
    return real2(j.pxPerM.x * (axis.x - j.clampedSlope.x * axis.z), j.pxPerM.y * (axis.y - j.clampedSlope.y * axis.z));
}

/** Determinant of the matrix with columns a and b. */
DPL_FN real determinantOf(real2 a, real2 b) {
    return a.x * b.y - b.x * a.y;
}

/** B·Bᵀ, px², before the low-pass: the screen covariance of a splat. detB2: its determinant, px⁴. */
struct Spread {
    real varianceX;
    real varianceY;
    real covariance;
    real detB2;
};

/** For a splat with two axes; b1, b2: the axes on the screen, px. */
DPL_FN Spread flatSpread(real2 b1, real2 b2) {
    Spread s;
    s.varianceX = b1.x * b1.x + b2.x * b2.x;
    s.varianceY = b1.y * b1.y + b2.y * b2.y;
    s.covariance = b1.x * b1.y + b2.x * b2.y;
    real detB = determinantOf(b1, b2);
    s.detB2 = detB * detB;
    return s;
}

/** For a splat with three axes. det(B·Bᵀ) is the sum of the squared 2×2 minors (Cauchy-Binet). */
DPL_FN Spread solidSpread(real2 b1, real2 b2, real2 b3) {
    Spread s;
    s.varianceX = b1.x * b1.x + b2.x * b2.x + b3.x * b3.x;
    s.varianceY = b1.y * b1.y + b2.y * b2.y + b3.y * b3.y;
    s.covariance = b1.x * b1.y + b2.x * b2.y + b3.x * b3.y;
    real m1 = determinantOf(b2, b3), m2 = determinantOf(b3, b1), m3 = determinantOf(b1, b2);
    s.detB2 = m1 * m1 + m2 * m2 + m3 * m3;
    return s;
}

/** A splat in one view, without its colour. */
struct Footprint {
    real2 centrePx;
    real conicA;  // [A B; B C] = Σ'⁻¹, 1/px²: σ = ½(A dx² + C dy²) + B dx dy
    real conicB;
    real conicC;
    real varianceX;  // diagonal of Σ', px²: the ellipse of squared radius q has the half widths √(q·variance)
    real varianceY;
    real inverseDet;  // 1/det Σ'
    real compensation;
    real depthM;    // view z
    truth visible;  // false: at or before the near plane, or not finite; the other fields may then hold anything
};

DPL_FN Footprint footprintOf(Lens lens, Jacobian j, real depthM, Spread s, real kappaPx2) {
    Footprint f;
    // det Σ' as a sum of positive terms: a·c − b² cancels in float for needles.
    real det = s.detB2 + kappaPx2 * (s.varianceX + s.varianceY + kappaPx2);
    f.inverseDet = real(1) / det;
    f.centrePx = centreOnScreen(lens, j);
    f.varianceX = s.varianceX + kappaPx2;
    f.varianceY = s.varianceY + kappaPx2;
    f.conicA = f.varianceY * f.inverseDet;
    f.conicB = -(s.covariance * f.inverseDet);
    f.conicC = f.varianceX * f.inverseDet;
    f.compensation = max(real(kMinCompensation), sqrt(s.detB2 * f.inverseDet));
    f.depthM = depthM;
    f.visible = depthM > real(kNearM) && det > real(0) && isFinite(det) && isFinite(f.centrePx.x) && isFinite(f.centrePx.y);
    return f;
}

/** Projects a splat with two axes; centre and axes in view space, m. */
DPL_FN Footprint projectFlat(Lens lens, real3 centre, real3 axis1, real3 axis2, real kappaPx2) {
    Jacobian j = jacobianAt(lens, centre);
    return footprintOf(lens, j, centre.z, flatSpread(axisOnScreen(j, axis1), axisOnScreen(j, axis2)), kappaPx2);
}

/** The same for three axes. */
DPL_FN Footprint projectSolid(Lens lens, real3 centre, real3 axis1, real3 axis2, real3 axis3, real kappaPx2) {
    Jacobian j = jacobianAt(lens, centre);
    Spread s = solidSpread(axisOnScreen(j, axis1), axisOnScreen(j, axis2), axisOnScreen(j, axis3));
    return footprintOf(lens, j, centre.z, s, kappaPx2);
}

/** Squared Mahalanobis radius q at which opacity·exp(−q/2) falls to kMinAlpha; negative when the splat is invisible. */
DPL_FN real visibleRadius2(real opacity) {
    return real(2) * log(opacity * real(1.0 / kMinAlpha));
}
