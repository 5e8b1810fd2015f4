// SPDX-License-Identifier: Apache-2.0
// Which tiles a splat touches. The includer declares the push constants as TilePush `push`.

// First and last tile that hold pixels with samples in [low, high], of `size` pixels. Always one at least: an entry too many shows nothing.
uvec2 dplTilesIn(float low, float high, uint size) {
    float last = float(size) - 1.0;
    int first = int(clamp(ceil(low - push.reachPx - 0.5), 0.0, last)), end = int(clamp(floor(high + push.reachPx - 0.5), 0.0, last));
    first = clamp(first, 0, int(size) - 1);  // a second time: what is not a number must not leave the lists
    return uvec2(first, clamp(end, first, int(size) - 1)) >> push.tileShift;
}

// The rows of tiles that its box touches.
uvec2 dplSplatRows(float centrePx, float radiusPx, uint heightPx) { return dplTilesIn(centrePx - radiusPx, centrePx + radiusPx, heightPx); }

// The columns of tiles that its 1/255 ellipse (dplEllipseOf) reaches within a row of tiles, from its first samples to its last. Each side of the ellipse is
// monotonous on either side of u = ±r.
uvec2 dplSplatColumns(vec2 centrePx, vec3 ellipse, uint row, uint widthPx) {
    float top = float(row << push.tileShift) + 0.5 - push.reachPx, bottom = float((row + 1u) << push.tileShift) - 0.5 + push.reachPx;
    float r = ellipse.z, across = 1.0 - r * r + 1e-6;  // the rest: float rounding of r
    float u0 = clamp((top - centrePx.y) / ellipse.y, -1.0, 1.0), u1 = clamp((bottom - centrePx.y) / ellipse.y, -1.0, 1.0);
    float right = clamp(r, u0, u1), left = clamp(-r, u0, u1);
    float high = r * right + sqrt(max(across * (1.0 - right * right), 0.0)), low = r * left - sqrt(max(across * (1.0 - left * left), 0.0));
    return dplTilesIn(centrePx.x + ellipse.x * low - 0.01, centrePx.x + ellipse.x * high + 0.01, widthPx);
}
