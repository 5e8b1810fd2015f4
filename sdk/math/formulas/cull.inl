// SPDX-License-Identifier: Apache-2.0
// Whether splats around a set of points can show in a view (docs/reference/footprint.md). Lossless: false only where every one of
// them is invisible. Needs footprint.inl.
//
// A splat shows when its centre px ± radius touches the target. radius ≤ √level · (f/z · σ |w| + √κ), w = (1, 0, −slope) with the
// slope clamped. Multiplied by z the condition is linear in the centre: what holds at no corner of a convex set holds nowhere in it.

/** How far splats reach beyond their centres: metres × px, and px. */
struct CullMargin {
    real2 reach;
    real2 marginPx;
};

/** reachM: largest √level · standard deviation, m; rootLevel: largest √level; slackPx: rounding, and reach of a pixel's samples. */
DPL_FN CullMargin cullMargin(Lens lens, real reachM, real rootLevel, real kappaPx2, real slackPx) {
    CullMargin m;
    real slopeX = max(abs(lens.minSlope.x), abs(lens.maxSlope.x)), slopeY = max(abs(lens.minSlope.y), abs(lens.maxSlope.y));
    m.reach = real2(lens.focalPx.x * reachM * sqrt(real(1) + slopeX * slopeX), lens.focalPx.y * reachM * sqrt(real(1) + slopeY * slopeY));
    real px = rootLevel * sqrt(kappaPx2) + slackPx;
    m.marginPx = real2(px + real(1e-5) * lens.focalPx.x, px + real(1e-5) * lens.focalPx.y);
    return m;
}

/** How far a point, with the reach of its splats, lies inside each side of the target (× its z; below 0: outside), and its view z. */
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

/** Of two points, the more visible one on each side. */
DPL_FN CullSides eitherSides(CullSides a, CullSides b) {
    CullSides s;
    s.left = max(a.left, b.left);
    s.right = max(a.right, b.right);
    s.above = max(a.above, b.above);
    s.below = max(a.below, b.below);
    s.depthM = max(a.depthM, b.depthM);
    return s;
}

/** Whether a splat of the set may show. The factor of the near plane is room for rounding. */
DPL_FN truth mayShow(CullSides s) {
    return s.left > real(0) && s.right > real(0) && s.above > real(0) && s.below > real(0) && s.depthM > real(0.999 * kNearM);
}

/** The largest factor by which the 3×2 matrix [f0 f1] stretches: its larger singular value. */
DPL_FN real largestStretch(real3 f0, real3 f1) {
    real a = dot(f0, f0), c = dot(f1, f1), b = dot(f0, f1), d = real(0.5) * (a - c);
    return sqrt(real(0.5) * (a + c) + sqrt(d * d + b * b));
}
