// SPDX-License-Identifier: Apache-2.0
// Whether splats whose centres lie in a convex set can show in a view (docs/reference/gate.md). The answer is "no" only when every one of
// them is invisible. Needs footprint.inl.
//
// A splat shows when its centre px ± radius touches the target. radius ≤ √level · (f/z · σ |w| + √κ), with w = (1, 0, −slope) and the
// slope clamped. Multiplied by z, the condition for each side of the target is linear in the centre. So if it fails at every corner of the
// set, it fails everywhere in it.

/** How far splats reach beyond their centres: (reach / z + marginPx) pixels, along x and y. */
struct CullMargin {
    real2 reach;  // px · m
    real2 marginPx;
};

/** reachM: largest √level · standard deviation, m; rootLevel: largest √level; slackPx: room for rounding and for the coverage samples.
 *  level = 2 ln(255 · opacity). */
DPL_FN CullMargin cullMargin(Lens lens, real reachM, real rootLevel, real kappaPx2, real slackPx) {
    CullMargin m;
    real slopeX = max(abs(lens.minSlope.x), abs(lens.maxSlope.x)), slopeY = max(abs(lens.minSlope.y), abs(lens.maxSlope.y));
    m.reach = real2(lens.focalPx.x * reachM * sqrt(real(1) + slopeX * slopeX), lens.focalPx.y * reachM * sqrt(real(1) + slopeY * slopeY));
    real px = rootLevel * sqrt(kappaPx2) + slackPx;
    m.marginPx = real2(px + real(1e-5) * lens.focalPx.x, px + real(1e-5) * lens.focalPx.y);
    return m;
}

/** Distance of a view-space point to each side of the target, with the reach of its splats added and times its z: px · m, negative =
 *  outside. And its view z. */
struct CullSides {
    real left;
    real right;
    real above;
    real below;
    real depthM;
};

DPL_FN CullSides cullSides(Lens lens, CullMargin m, real2 targetPx, real3 point) {
    CullSides s;
    real x = lens.focalPx.x * point.x, y = lens.focalPx.y * point.y;
    s.left = m.reach.x + x + (lens.centrePx.x + m.marginPx.x) * point.z;
    s.right = m.reach.x - x + (targetPx.x - lens.centrePx.x + m.marginPx.x) * point.z;
    s.above = m.reach.y + y + (lens.centrePx.y + m.marginPx.y) * point.z;
    s.below = m.reach.y - y + (targetPx.y - lens.centrePx.y + m.marginPx.y) * point.z;
    s.depthM = point.z;
    return s;
}

/** Side by side, the value of the point that lies farther inside. */
DPL_FN CullSides eitherSides(CullSides a, CullSides b) {
    CullSides s;
    s.left = max(a.left, b.left);
    s.right = max(a.right, b.right);
    s.above = max(a.above, b.above);
    s.below = max(a.below, b.below);
    s.depthM = max(a.depthM, b.depthM);
    return s;
}

/** Whether a splat of the set may show. s: eitherSides of all corners. The factor 0.999 is room for rounding. */
DPL_FN truth mayShow(CullSides s) {
    return s.left > real(0) && s.right > real(0) && s.above > real(0) && s.below > real(0) && s.depthM > real(0.999 * kNearM);
}

/** Larger singular value of the 3×2 matrix [f0 f1]: the largest factor by which it stretches a vector. */
DPL_FN real largestStretch(real3 f0, real3 f1) {
    real a = dot(f0, f0), c = dot(f1, f1), b = dot(f0, f1), d = real(0.5) * (a - c);
    return sqrt(real(0.5) * (a + c) + sqrt(d * d + b * b));
}
