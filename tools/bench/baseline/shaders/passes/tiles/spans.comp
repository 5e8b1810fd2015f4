// SPDX-License-Identifier: Apache-2.0
// Writes the spans: for each splat and row of tiles the columns that it touches there. They end up row after row, in the order of depth within a row.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "tools/bench/baseline/shaders/shared/tiles.h"
#include "tools/bench/baseline/shaders/lib/tiles.glsl"
layout(local_size_x = 32) in;  // kTileListGroup

layout(std430, binding = 0) readonly buffer PairBlock { uvec2 pairs[]; };
layout(std430, binding = 1) readonly buffer ProjectedBlock { ProjectedSplat projected[]; };
layout(std430, binding = 2) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 3) buffer ListBlock { uint lists[]; };
layout(push_constant) uniform PushBlock { TilePush push; };

void main() {
    uint run = gl_GlobalInvocationID.x, runs = (counts.visible + kTileRun - 1u) / kTileRun;
    if (run >= runs) return;
    uint end = min((run + 1u) * kTileRun, counts.visible);
    for (uint i = run * kTileRun; i < end; ++i) {
        uint splat = pairs[i].y;
        if (projected[splat].opacity == 0.0) continue;
        ProjectedSplat p = projected[splat];
        ivec2 rows = dplSplatRows(p, push.heightPx);
        if (rows.x > rows.y) continue;
        for (uint row = uint(rows.x) / kTilePx; row <= uint(rows.y) / kTilePx; ++row) {
            float top = float(row * kTilePx) + 0.5;
            ivec2 columns = dplSplatColumns(p, top, top + float(kTilePx - 1u), push.widthPx);
            uint cursor = push.firstRunTable + row * runs + run, span = push.firstSpan + 2u * (lists[push.firstSpanSum + row] + lists[cursor]);
            lists[cursor]++;
            lists[span] = splat;
            lists[span + 1u] = columns.x > columns.y ? 1u : uint(columns.x) / kTilePx | (uint(columns.y) / kTilePx) << 16u;  // 1: first 1, last 0
        }
    }
}
