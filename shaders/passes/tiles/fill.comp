// SPDX-License-Identifier: Apache-2.0
// Composites the pixels of each tile from its list, nearest first. One lane owns one column of a tile. It takes four splats at a time
// (two at four samples) and stops when the transmittance of all its samples is used up.
// DPL_SHUFFLE: the eight (four) lanes of a tile fetch together: each pair of lanes loads one record, half each, and shares it by
// shuffles. For devices whose subgroups hold whole tiles (DeviceInfo::shuffle); the picture is the same but for rounding.
// DPL_SCENE_DEPTH: a splat adds nothing to pixels where it lies behind the app's scene, whose depths are in the pixel buffer.
// DPL_FOUR_SAMPLES: each pixel is composited at four places and averaged (docs/reference/coverage.md). Averaging is linear, so colour and
// depth are summed over the samples at once; only the transmittance is kept for each sample.
#version 450
#extension GL_GOOGLE_include_directive : require
#ifdef DPL_SHUFFLE
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#endif
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/projected.glsl"
#include "sdk/math/formulas/constants.h"
layout(local_size_x = 64) in;  // kTileGroup

DPL_WORDS(0, PlaceBlock, places);
DPL_WORDS(1, EntryBlock, entries);
DPL_FOURS(2, ProjectedBlock, projected);  // ProjectedSplat
#ifdef DPL_SCENE_DEPTH
#define DPL_PIXEL_ACCESS
#else
#define DPL_PIXEL_ACCESS writeonly
#endif
// zero before this pass: a tile without entries is not written
layout(std430, binding = 3) DPL_PIXEL_ACCESS buffer PixelBlock { uint pixels[]; };
layout(push_constant) uniform PushBlock { TilePush push; };

#ifdef DPL_FOUR_SAMPLES
const uint kSide = 1u << kFourTilePxShift, kSamples = kCoverageSamples;
#define kPlaces kCoverageSamplePx
#else
const uint kSide = 1u << kTilePxShift, kSamples = 1u;
const vec2 kPlaces[1] = vec2[](vec2(0.5));
#endif
const uint kBatch = kSide / 2u;          // records that the lanes of a tile fetch together
const float kReach = 0.5 * float(kSide - 1u);  // from the middle of a column to its last pixel centre, px
const float kShare = 1.0 / float(kSamples);

void main() {
    uint tileCount = push.viewCount * push.rows * push.columns;
    for (uint tile = gl_GlobalInvocationID.x / kSide; tile < tileCount; tile += push.fillGroups * (kTileGroup / kSide)) {
        uint row = tile / push.columns, end = DPL_WORD(places, push.firstTileTable + (tile + 1u) * kTileSegments - 1u);
        uint begin = tile == 0u ? 0u : DPL_WORD(places, push.firstTileTable + tile * kTileSegments - 1u);
        if (begin == end) continue;
        uint view = row / push.rows, x = (tile % push.columns) * kSide + gl_GlobalInvocationID.x % kSide, y = (row % push.rows) * kSide;
        vec2 middle = vec2(float(x), float(y) + kReach);  // middle of the column, without the offset of the sample in its pixel
        float through[kSamples * kSide];
        vec3 colour[kSide];
        float depth[kSide];
        for (uint k = 0u; k < kSide; ++k) {
            for (uint s = 0u; s < kSamples; ++s) through[s * kSide + k] = 1.0;
            colour[k] = vec3(0.0);
            depth[k] = 0.0;
        }
#ifdef DPL_SCENE_DEPTH
        float scene[kSide];
        for (uint k = 0u; k < kSide; ++k)
            scene[k] = uintBitsToFloat(pixels[push.firstScene + (view * push.heightPx + min(y + k, push.heightPx - 1u)) * push.widthPx + min(x, push.widthPx - 1u)]);
#endif
        float live = 1.0;
#ifdef DPL_SHUFFLE
        uint lane = gl_LocalInvocationIndex % kSide, firstLane = gl_SubgroupInvocationID - lane;
        for (uint batch = begin; batch < end; batch += kBatch) {
            uvec4 mine = DPL_FOUR(projected, kProjectedFours * DPL_WORD(entries, min(batch + lane / 2u, end - 1u)) + lane % 2u);
            ProjectedSplat odd = dplProjected(uvec4(0u), mine);  // meaningful only in lanes that hold the second half of a record
            float bendOf = exp(-odd.conicC), opacityOf = dplOpacityOf(odd.opacityAndRadius);
            for (uint j = 0u; j < kBatch; ++j) {
                uint first = firstLane + 2u * j, second = first + 1u;
                ProjectedSplat p = dplProjected(
                    uvec4(subgroupShuffle(mine.x, first), subgroupShuffle(mine.y, first), subgroupShuffle(mine.z, first), subgroupShuffle(mine.w, first)),
                    uvec4(subgroupShuffle(mine.x, second), 0u, subgroupShuffle(mine.z, second), subgroupShuffle(mine.w, second)));
                // past the end of the list the last record is fetched again, with opacity 0
                float bend = subgroupShuffle(bendOf, second), opacity = batch + j < end ? live * subgroupShuffle(opacityOf, second) : 0.0;
#else
        for (uint batch = begin; batch < end && live > 0.0; batch += kBatch) {
            for (uint i = batch; i < min(batch + kBatch, end); ++i) {
                uint record = kProjectedFours * DPL_WORD(entries, i);
                ProjectedSplat p = dplProjected(DPL_FOUR(projected, record), DPL_FOUR(projected, record + 1u));
                float bend = exp(-p.conicC), opacity = dplOpacityOf(p.opacityAndRadius);
#endif
                vec3 rgb = dplUnpackColour(p.colour);
                float weight[kSide];
                for (uint k = 0u; k < kSide; ++k) weight[k] = 0.0;
                for (uint s = 0u; s < kSamples; ++s) {
                    // α is computed at the end of the column nearer to its peak, and stepped from there by factors: σ is quadratic, so
                    // the factor of exp(-σ) itself changes by the constant factor exp(-C). The peak is at most half a column away, so
                    // the low-pass keeps the factors in float range (kTileMinKappaPx2).
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
            float most = 0.0;
            for (uint k = 0u; k < kSamples * kSide; ++k) most = max(most, through[k]);
            if (most < kTileStop) live = 0.0;
#ifdef DPL_SHUFFLE
            float any = live;
            for (uint step = 1u; step < kSide; step *= 2u) any = max(any, subgroupShuffleXor(any, step));
            if (any == 0.0) break;
#endif
        }
        if (x >= push.widthPx) continue;
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
}
