// The pixels of each tile from its list, near first. A lane owns one column of a tile, takes its splats by fours and stops when no pixel
// of it lets light through.
// DPL_SHUFFLE: the eight lanes of a tile fetch together, a pair of them half a record each, and hand the words around: four records for the loads of
// one. For devices whose subgroups hold whole tiles (DeviceInfo::shuffle); same bytes.
// DPL_SCENE_DEPTH: a splat adds nothing to pixels where it lies behind the app's scene, whose depths come in the buffer of pixels.
#version 450
#extension GL_GOOGLE_include_directive : require
#ifdef DPL_SHUFFLE
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#endif
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/footprint.glsl"
#include "shaders/lib/projected.glsl"
layout(local_size_x = 64) in;  // kTileGroup

DPL_WORDS(0, PlaceBlock, places);
DPL_WORDS(1, EntryBlock, entries);
DPL_FOURS(2, ProjectedBlock, projected);  // ProjectedSplat: place, look, radius
#ifdef DPL_SCENE_DEPTH
#define DPL_PIXEL_ACCESS
#else
#define DPL_PIXEL_ACCESS writeonly
#endif
layout(std430, binding = 3) DPL_PIXEL_ACCESS buffer PixelBlock { uint pixels[]; };  // zero before: a tile without entries is left alone
layout(push_constant) uniform PushBlock { TilePush push; };

void main() {
    uint tileCount = push.viewCount * push.rows * push.columns;
    for (uint tile = gl_GlobalInvocationID.x / kTilePx; tile < tileCount; tile += push.fillGroups * (kTileGroup / kTilePx)) {
        uint row = tile / push.columns, end = DPL_WORD(places, push.firstTileTable + (tile + 1u) * kTileSegments - 1u);
        uint begin = tile == 0u ? 0u : DPL_WORD(places, push.firstTileTable + tile * kTileSegments - 1u);
        if (begin == end) continue;
        uint view = row / push.rows, x = (tile % push.columns) * kTilePx + gl_GlobalInvocationID.x % kTilePx, y = (row % push.rows) * kTilePx;
        vec2 centre = vec2(float(x) + 0.5, float(y) + 0.5);
        float through[8];  // kTilePx
        vec3 colour[8];
        float depth[8];
        for (uint k = 0u; k < 8u; ++k) {
            through[k] = 1.0;
            colour[k] = vec3(0.0);
            depth[k] = 0.0;
        }
#ifdef DPL_SCENE_DEPTH
        float scene[8];
        for (uint k = 0u; k < 8u; ++k)
            scene[k] = uintBitsToFloat(pixels[push.firstScene + (view * push.heightPx + min(y + k, push.heightPx - 1u)) * push.widthPx + min(x, push.widthPx - 1u)]);
#endif
        float live = 1.0;
#ifdef DPL_SHUFFLE
        uint lane = gl_LocalInvocationIndex % kTilePx, firstLane = gl_SubgroupInvocationID - lane;
        for (uint batch = begin; batch < end; batch += 4u) {
            uvec4 mine = DPL_FOUR(projected, 3u * DPL_WORD(entries, min(batch + lane / 2u, end - 1u)) + lane % 2u);
            float bendOf = exp(-uintBitsToFloat(mine.x));  // in the lanes that hold a conic C
            for (uint j = 0u; j < 4u; ++j) {
                uint place = firstLane + 2u * j, look = place + 1u;
                vec4 at = vec4(uintBitsToFloat(subgroupShuffle(mine.x, place)), uintBitsToFloat(subgroupShuffle(mine.y, place)),
                               uintBitsToFloat(subgroupShuffle(mine.z, place)), uintBitsToFloat(subgroupShuffle(mine.w, place)));
                uvec4 seen = uvec4(subgroupShuffle(mine.x, look), subgroupShuffle(mine.y, look), subgroupShuffle(mine.z, look), subgroupShuffle(mine.w, look));
                float bend = subgroupShuffle(bendOf, look), opacity = batch + j < end ? live * uintBitsToFloat(seen.y) : 0.0;  // behind the end: the last record, again
#else
        for (uint batch = begin; batch < end && live > 0.0; batch += 4u) {
            for (uint i = batch; i < min(batch + 4u, end); ++i) {
                uint record = 3u * DPL_WORD(entries, i);
                vec4 at = uintBitsToFloat(DPL_FOUR(projected, record));
                uvec4 seen = DPL_FOUR(projected, record + 1u);
                float bend = exp(-uintBitsToFloat(seen.x)), opacity = uintBitsToFloat(seen.y);
#endif
                // α at the fifth pixel of the column, and from there by factors: exp(-σ) of a quadratic σ has factors that change by one factor, exp(-C).
                // The low-pass keeps that in range (kTileMinKappaPx2); what is clamped would be below 1/255 anyway.
                vec2 d = vec2(centre.x - at.x, centre.y + 4.0 - at.y);
                float conicC = uintBitsToFloat(seen.x), slope = at.w * d.x + conicC * d.y;
                float up = opacity * exp(-max(0.5 * (at.z * d.x * d.x + conicC * d.y * d.y) + at.w * d.x * d.y, 0.0)), down = up;
                float rise = exp(-clamp(slope + 0.5 * conicC, -60.0, 60.0)), fall = bend / rise;
                float alpha[8];
                for (uint k = 0u; k < 4u; ++k) {
                    alpha[4u + k] = up;
                    up *= rise;
                    rise *= bend;
                    down *= fall;
                    fall *= bend;
                    alpha[3u - k] = down;
                }
                vec3 rgb = dplUnpackColour(seen.z);
                for (uint k = 0u; k < 8u; ++k) {
                    float weight = (alpha[k] >= kGpuMinAlpha ? min(kGpuMaxAlpha, alpha[k]) : 0.0) * through[k];
#ifdef DPL_SCENE_DEPTH
                    if (uintBitsToFloat(seen.w) > scene[k]) weight = 0.0;
#endif
                    colour[k] += weight * rgb;
#ifdef DPL_DEPTH
                    depth[k] += weight * uintBitsToFloat(seen.w);
#endif
                    through[k] -= weight;
                }
            }
            float most = 0.0;
            for (uint k = 0u; k < 8u; ++k) most = max(most, through[k]);
            if (most < kTileStop) live = 0.0;
#ifdef DPL_SHUFFLE
            float any = max(live, subgroupShuffleXor(live, 1u));
            any = max(any, subgroupShuffleXor(any, 2u));
            if (max(any, subgroupShuffleXor(any, 4u)) == 0.0) break;
#endif
        }
        if (x >= push.widthPx) continue;
        for (uint k = 0u; k < 8u; ++k) {
            if (y + k >= push.heightPx) break;
            uint pixel = (view * push.heightPx + y + k) * push.widthPx + x;
            vec4 rgba = vec4(colour[k], 1.0 - through[k]);
            pixels[pixel] = packUnorm4x8(rgba);
#ifdef DPL_DEPTH
            if (push.halfDepth != 0u) {
                pixels[push.firstDepth + pixel] = packHalf2x16(vec2(depth[k], rgba.w));
            } else {
                pixels[push.firstDepth + 2u * pixel] = floatBitsToUint(depth[k]);
                pixels[push.firstDepth + 2u * pixel + 1u] = floatBitsToUint(rgba.w);
            }
#endif
        }
    }
}
