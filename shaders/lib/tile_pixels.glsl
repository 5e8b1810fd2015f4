// SPDX-License-Identifier: Apache-2.0
// The pixels of a column of a tile. One lane owns a column and composites it nearest first, until the transmittance of all its samples is
// used up. The includer declares `pixels`, zero before the pass, and the push constants as TilePush `push`.
// DPL_SCENE_DEPTH: a splat adds nothing to pixels where it lies behind the app's scene, whose depths are in the pixel buffer.
// DPL_FOUR_SAMPLES: each pixel is composited at four places and averaged (docs/reference/coverage.md). Averaging is linear, so colour and
// depth are summed over the samples at once; only the transmittance is kept for each sample.
#ifdef DPL_FOUR_SAMPLES
const uint kSide = 1u << kFourTilePxShift, kSamples = kCoverageSamples;
#define kPlaces kCoverageSamplePx
#else
const uint kSide = 1u << kTilePxShift, kSamples = 1u;
const vec2 kPlaces[1] = vec2[](vec2(0.5));
#endif
const uint kBatch = kSide / 2u;                // splats between two looks at the transmittance
const float kReach = 0.5 * float(kSide - 1u);  // from the middle of a column to its last pixel centre, px
const float kShare = 1.0 / float(kSamples);

float live;   // 0: the transmittance of the column is used up
vec2 middle;  // of the column, without the offset of the sample in its pixel
float through[kSamples * kSide];
vec3 colour[kSide];
float depth[kSide];
#ifdef DPL_SCENE_DEPTH
float scene[kSide];
#endif

/** x, y: the first pixel. */
void dplStartColumn(uint view, uint x, uint y) {
    middle = vec2(float(x), float(y) + kReach);
    live = 1.0;
    for (uint k = 0u; k < kSide; ++k) {
        for (uint s = 0u; s < kSamples; ++s) through[s * kSide + k] = 1.0;
        colour[k] = vec3(0.0);
        depth[k] = 0.0;
#ifdef DPL_SCENE_DEPTH
        scene[k] = uintBitsToFloat(pixels[push.firstScene + (view * push.heightPx + min(y + k, push.heightPx - 1u)) * push.widthPx + min(x, push.widthPx - 1u)]);
#endif
    }
}

/** bend: exp(-conicC). */
void dplAddSplat(ProjectedSplat p, float bend, float opacity) {
    vec3 rgb = dplUnpackColour(p.colour);
    float weight[kSide];
    for (uint k = 0u; k < kSide; ++k) weight[k] = 0.0;
    for (uint s = 0u; s < kSamples; ++s) {
        // α is computed at the end of the column nearer to its peak, and stepped from there by factors: σ is quadratic, so the factor of
        // exp(-σ) itself changes by the constant factor exp(-C). The peak is at most half a column away, so the low-pass keeps the
        // factors in float range (kTileMinKappaPx2).
        vec2 d = middle + kPlaces[s] - p.centrePx;
        float slope = p.conicB * d.x + p.conicC * d.y;
        bool first = slope > 0.0;
        d.y += first ? -kReach : kReach;
        float step = opacity * exp(-max(0.5 * (p.conicA * d.x * d.x + p.conicC * d.y * d.y) + p.conicB * d.x * d.y, 0.0));
        float factor = exp((kReach - 0.5) * p.conicC - abs(slope)), steps[kSide];
        for (uint k = 0u; k < kSide; ++k) {
            steps[k] = step;
            step *= factor;
            factor *= bend;
        }
        for (uint k = 0u; k < kSide; ++k) {
            float alpha = first ? steps[k] : steps[kSide - 1u - k];
            float part = (alpha >= kMinAlpha ? min(kMaxAlpha, alpha) : 0.0) * through[s * kSide + k];
#ifdef DPL_SCENE_DEPTH
            if (p.depthM > scene[k]) part = 0.0;
#endif
            weight[k] += part;
            through[s * kSide + k] -= part;
        }
    }
    for (uint k = 0u; k < kSide; ++k) {
        colour[k] += weight[k] * rgb;
#ifdef DPL_DEPTH
        depth[k] += weight[k] * p.depthM;
#endif
    }
}

void dplLookThrough() {
    float most = 0.0;
    for (uint k = 0u; k < kSamples * kSide; ++k) most = max(most, through[k]);
    if (most < kTileStop) live = 0.0;
}

void dplWriteColumn(uint view, uint x, uint y) {
    if (x >= push.widthPx) return;
    for (uint k = 0u; k < kSide; ++k) {
        if (y + k >= push.heightPx) break;
        uint pixel = (view * push.heightPx + y + k) * push.widthPx + x;
        float left = 0.0;
        for (uint s = 0u; s < kSamples; ++s) left += through[s * kSide + k];
        vec4 rgba = vec4(kShare * colour[k], 1.0 - kShare * left);
        pixels[pixel] = packUnorm4x8(rgba);
#ifdef DPL_DEPTH
        if (push.halfDepth != 0u) {
            pixels[push.firstDepth + pixel] = packHalf2x16(vec2(kShare * depth[k], rgba.w));
        } else {
            pixels[push.firstDepth + 2u * pixel] = floatBitsToUint(kShare * depth[k]);
            pixels[push.firstDepth + 2u * pixel + 1u] = floatBitsToUint(rgba.w);
        }
#endif
    }
}
