// SPDX-License-Identifier: Apache-2.0
// The pixels of each tile from its list, near first. A lane owns one column of a tile and stops when no pixel of it lets light through.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/tiles.h"
#include "tools/bench/baseline/shaders/lib/alpha.glsl"
layout(local_size_x = 64) in;  // kTileGroup

layout(std430, binding = 0) readonly buffer ListBlock { uint lists[]; };
layout(std430, binding = 1) readonly buffer EntryBlock { uint entries[]; };
layout(std430, binding = 2) readonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 3) writeonly buffer PixelBlock { uint pixels[]; };  // zero before: a tile without entries is left alone
layout(push_constant) uniform PushBlock { TilePush push; };

void main() {
    uint tileCount = push.rows * push.columns;
    for (uint tile = gl_GlobalInvocationID.x / kTilePx; tile < tileCount; tile += push.fillGroups * (kTileGroup / kTilePx)) {
        uint row = tile / push.columns, end = push.firstTileTable + (tile + 1u) * kTileSegments - 1u, place = lists[push.firstEntrySum + row];
        uint begin = place + (tile % push.columns == 0u ? 0u : lists[end - kTileSegments]);
        end = place + lists[end];
        if (begin == end) continue;
        uint x = (tile % push.columns) * kTilePx + gl_GlobalInvocationID.x % kTilePx, y = row * kTilePx;
        vec2 centre = vec2(float(x) + 0.5, float(y) + 0.5);
        float through[8];  // kTilePx
        vec3 colour[8];
        for (uint k = 0u; k < 8u; ++k) {
            through[k] = 1.0;
            colour[k] = vec3(0.0);
        }
        for (uint i = begin; i < end; ++i) {
            ProjectedSplat p = projected[entries[i]];
            vec2 d = centre - p.centrePx;
            vec3 conic = vec3(p.conicA, p.conicB, p.conicC);
            float most = 0.0;
            for (uint k = 0u; k < 8u; ++k) {
                float weight = dplSplatAlpha(vec2(d.x, d.y + float(k)), conic, p.opacity) * through[k];
                colour[k] += weight * p.colour.rgb;
                through[k] -= weight;
                most = max(most, through[k]);
            }
            if (most < kTileStop) break;
        }
        if (x >= push.widthPx) continue;
        for (uint k = 0u; k < 8u; ++k) {
            if (y + k >= push.heightPx) break;
            pixels[(y + k) * push.widthPx + x] = packUnorm4x8(vec4(colour[k], 1.0 - through[k]));
        }
    }
}
