// SPDX-License-Identifier: Apache-2.0
// Whether a triangle's splats can show in a view. Lossless: it is false only where lib/footprint.glsl and project.comp would drop every one of them.
//
// A splat shows when its centre px ± radius touches the target. radius ≤ √level (f/z · σ |w| + √κ), w = (1, 0, −slope) with the slope clamped, so
// with everything multiplied by z the condition is linear in the centre: what holds at no corner of the triangle holds nowhere on it.
bool dplTriangleInView(ViewData view, vec3 corner0, vec3 corner1, vec3 corner2, float reachM, float rootLevel, vec2 targetPx, float kappa) {
    vec3 c0 = dplToView(view, corner0), c1 = dplToView(view, corner1), c2 = dplToView(view, corner2);
    vec2 focal = view.focalCentrePx.xy, centre = view.focalCentrePx.zw;
    vec2 slope = max(abs(view.slopeLimits.xz), abs(view.slopeLimits.yw));
    vec2 reach = focal * reachM * sqrt(1.0 + slope * slope);
    vec2 margin = rootLevel * sqrt(kappa) + 0.02 + 1e-5 * focal;  // the rest: float rounding
    vec2 a = centre + margin, b = targetPx - centre + margin;
    vec2 fromLow = reach + max(focal * c0.xy + a * c0.z, max(focal * c1.xy + a * c1.z, focal * c2.xy + a * c2.z));
    vec2 fromHigh = reach + max(b * c0.z - focal * c0.xy, max(b * c1.z - focal * c1.xy, b * c2.z - focal * c2.xy));
    float farthest = max(c0.z, max(c1.z, c2.z));
    return fromLow.x > 0.0 && fromLow.y > 0.0 && fromHigh.x > 0.0 && fromHigh.y > 0.0 && farthest > kGpuNearM;
}

/** The largest factor by which the 3×2 matrix [f0 f1] stretches. */
float dplLargestStretch(vec3 f0, vec3 f1) {
    float a = dot(f0, f0), c = dot(f1, f1), b = dot(f0, f1), d = 0.5 * (a - c);
    return sqrt(0.5 * (a + c) + sqrt(d * d + b * b));
}
