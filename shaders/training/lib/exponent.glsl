// SPDX-License-Identifier: Apache-2.0
// Opacity of a splat at a pixel, as the trainer on the CPU computes it: α = 2^(row + scale·along²).
const float kLog2E = 1.44269504;
const float kLog2MinAlpha = -7.99435344;  // log2(1/255)

/** Constants of one splat. log2(opacity') follows from the radius of its box: radiusY²/Σ'yy = 2 ln(255·opacity'). */
struct SplatExponent {
    vec2 centrePx;
    float slope, scale, rowScale, logOpacity;
};

SplatExponent splatExponent(TrainScreen p) {
    float perVariance = 0.5 * kLog2E * p.inverseVarianceY;
    return SplatExponent(vec2(p.x, p.y), p.conicB / p.conicA, -0.5 * kLog2E * p.conicA, -perVariance,
                         perVariance * p.radiusY * p.radiusY + kLog2MinAlpha);
}

/** log2 of the opacity; below kLog2MinAlpha the splat does not touch the pixel. offset: pixel − centre. */
float exponentAt(SplatExponent e, vec2 offset) {
    float along = offset.x + e.slope * offset.y;
    return e.scale * along * along + (e.logOpacity + e.rowScale * offset.y * offset.y);
}
