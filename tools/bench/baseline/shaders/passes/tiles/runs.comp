// SPDX-License-Identifier: Apache-2.0
// How many rows of tiles the splats of each run touch: [row][run]. A run is kTileRun neighbours of the sorted list; one lane counts it, so that the
// order of the lists is the order of depth without atomics or barriers.
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
    uint table = push.firstRunTable + run;
    for (uint row = 0u; row < push.rows; ++row) lists[table + row * runs] = 0u;
    uint end = min((run + 1u) * kTileRun, counts.visible);
    for (uint i = run * kTileRun; i < end; ++i) {
        uint splat = pairs[i].y;
        if (projected[splat].opacity == 0.0) continue;
        ivec2 rows = dplSplatRows(projected[splat], push.heightPx);
        if (rows.x > rows.y) continue;
        for (uint row = uint(rows.x) / kTilePx; row <= uint(rows.y) / kTilePx; ++row) lists[table + row * runs]++;
    }
}
