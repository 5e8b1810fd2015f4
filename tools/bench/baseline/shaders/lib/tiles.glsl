// SPDX-License-Identifier: Apache-2.0
// Which tiles a splat touches.

// First and last pixel whose centres lie in [low, high], cut to 0 .. size - 1; first > last: none.
ivec2 dplPixelsIn(float low, float high, uint size) {
    float last = float(size) - 1.0;
    int first = int(clamp(ceil(low - 0.5), 0.0, last + 1.0)), end = int(clamp(floor(high - 0.5), -1.0, last));
    return ivec2(clamp(first, 0, int(size)), clamp(end, -1, int(size) - 1));  // a second time: what is not a number must not leave the lists
}

// The pixel rows of a splat's box.
ivec2 dplSplatRows(ProjectedSplat p, uint heightPx) { return dplPixelsIn(p.centrePx.y - p.radiusPx.y, p.centrePx.y + p.radiusPx.y, heightPx); }

// The pixel columns that its 1/255 ellipse reaches within a strip of rows [top, bottom] (pixel centres). In units of the radii the ellipse is
// x = r u ± √((1 - r²)(1 - u²)) with r the correlation; each side of it is monotonous on either side of u = ±r.
ivec2 dplSplatColumns(ProjectedSplat p, float top, float bottom, uint widthPx) {
    float r = -p.conicB * inversesqrt(p.conicA * p.conicC), across = 1.0 - r * r + 1e-6;  // the rest: float rounding of r
    float u0 = clamp((top - p.centrePx.y) / p.radiusPx.y, -1.0, 1.0), u1 = clamp((bottom - p.centrePx.y) / p.radiusPx.y, -1.0, 1.0);
    float right = clamp(r, u0, u1), left = clamp(-r, u0, u1);
    float high = r * right + sqrt(max(across * (1.0 - right * right), 0.0)), low = r * left - sqrt(max(across * (1.0 - left * left), 0.0));
    return dplPixelsIn(p.centrePx.x + p.radiusPx.x * low - 0.01, p.centrePx.x + p.radiusPx.x * high + 0.01, widthPx);
}
