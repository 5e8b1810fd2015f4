// SPDX-License-Identifier: Apache-2.0
// How the raw parameters of a splat become what is drawn, for the trainer on the CPU and its kernels (shaders/training). Rules of the
// subset: sdk/math/formulas/README.md, except that a `truth` is one value, which may be branched on.

/** Projection of (u, v) onto {u ≥ 0, v ≥ 0, u + v ≤ 1}, Euclidean in the barycentric coordinates (1 − u − v, u, v). These already lie in
 *  the plane of the triangle, so the projection clips negative ones and takes the excess from the others. */
DPL_FN real2 nearestOnTriangle(real2 uv) {
    real b0 = real(1) - uv.x - uv.y, b1 = uv.x, b2 = uv.y;
    // 1 − u − v of a projected point may be −1e-7 by rounding. Accepting it makes the projection idempotent, so that a restored run gives
    // the same bytes.
    if (b0 >= real(-1e-6) && b1 >= real(0) && b2 >= real(0)) return uv;
    real largest = max(b0, max(b1, b2)), smallest = min(b0, min(b1, b2)), middle = max(min(b0, b1), min(max(b0, b1), b2));
    real shift = real(0), sum = largest, candidate = sum - real(1);
    if (largest - candidate > real(0)) shift = candidate;
    sum += middle;
    candidate = (sum - real(1)) / real(2);
    if (middle - candidate > real(0)) shift = candidate;
    sum += smallest;
    candidate = (sum - real(1)) / real(3);
    if (smallest - candidate > real(0)) shift = candidate;
    return real2(max(real(0), b1 - shift), max(real(0), b2 - shift));
}
