// SPDX-License-Identifier: Apache-2.0
// Which tiles a splat touches. The includer includes lib/projected.glsl, and declares `projected` by DPL_FOURS and the push constants as
// TilePush `push`.

// First and last tile with pixels that have samples in [low, high]; `size` is in pixels. The result has at least one tile: a needless
// entry draws nothing.
uvec2 dplTilesIn(float low, float high, uint size) {
    precise float from = low - push.reachPx - 0.5, to = high + push.reachPx - 0.5, last = float(size) - 1.0;
    int first = int(clamp(ceil(from), 0.0, last)), end = int(clamp(floor(to), 0.0, last));
    first = clamp(first, 0, int(size) - 1);  // clamps again after the conversion to int, so that a NaN cannot leave the lists
    return uvec2(first, clamp(end, first, int(size) - 1)) >> push.tileShift;
}

const uvec2 kNoTiles = uvec2(1u, 0u);  // from the first to the last

// First and last row of tiles that the bounding box touches; none where the view does not show the splat. One kernel counts spans by it
// and another writes them, so what it computes is `precise`: a compiler that fused a product and a sum in one of them only could make
// lists that are longer than was counted.
uvec2 dplRowsOf(ProjectedSplat p, SplatEllipse ellipse) {
    precise float low = p.centrePx.y - ellipse.radiusYPx, high = p.centrePx.y + ellipse.radiusYPx;
    return dplShown(p.opacityAndRadius) ? dplTilesIn(low, high, push.heightPx) : kNoTiles;
}

// First and last column of tiles that the 1/255 ellipse (dplEllipseOf) touches within a row of tiles, from the first samples of the row
// to the last. The outline is monotonic on either side of u = r and of u = -r, so the extremes are at those points or at the ends.
uvec2 dplSplatColumns(vec2 centrePx, SplatEllipse ellipse, uint row, uint widthPx) {
    float top = float(row << push.tileShift) + 0.5 - push.reachPx, bottom = float((row + 1u) << push.tileShift) - 0.5 + push.reachPx;
    float r = ellipse.correlation, across = 1.0 - r * r + 1e-6;  // 1e-6 absorbs float rounding of r
    float u0 = clamp((top - centrePx.y) / ellipse.radiusYPx, -1.0, 1.0), u1 = clamp((bottom - centrePx.y) / ellipse.radiusYPx, -1.0, 1.0);
    float right = clamp(r, u0, u1), left = clamp(-r, u0, u1);
    float high = r * right + sqrt(max(across * (1.0 - right * right), 0.0)), low = r * left - sqrt(max(across * (1.0 - left * left), 0.0));
    return dplTilesIn(centrePx.x + ellipse.radiusXPx * low - 0.01, centrePx.x + ellipse.radiusXPx * high + 0.01, widthPx);
}

ProjectedSplat dplRecord(uint slot) {
    return dplProjected(DPL_FOUR(projected, kProjectedFours * slot), DPL_FOUR(projected, kProjectedFours * slot + 1u));
}
