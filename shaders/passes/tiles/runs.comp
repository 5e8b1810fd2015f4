// SPDX-License-Identifier: Apache-2.0
// Counts the spans of each run in each row of tiles: [row][run]. A run is kRun neighbours of the sorted list, and one lane counts it,
// so the lists are in depth order without atomics or barriers.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/views.glsl"
#include "shaders/lib/projected.glsl"
layout(local_size_x = 32) in;  // kRunGroup

DPL_WORDS(0, OrderBlock, order);
DPL_FOURS(1, ProjectedBlock, projected);  // ProjectedSplat
layout(std430, binding = 2) readonly buffer CountsBlock { FrameCounts counts; };
layout(std430, binding = 3) buffer TableBlock { uint table[]; };  // zero before this pass
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/tiles.glsl"

void main() {
    uint run = gl_GlobalInvocationID.x, runs = counts.runs;
    if (run >= runs) return;
    uint first = push.firstRunTable + run;
    uint end = min((run + 1u) * kRun, counts.visible);
    for (uint i = run * kRun; i < end; ++i) {
        uint splat = DPL_WORD(order, i);
        for (uint v = 0u; v < kViews; ++v) {
            uint record = kProjectedFours * (v * push.splatCount + splat);
            ProjectedSplat p = dplProjected(DPL_FOUR(projected, record), DPL_FOUR(projected, record + 1u));
            uint one = dplShown(p.opacityAndRadius) ? 1u : 0u;
            uvec2 rows = one * dplSplatRows(p.centrePx.y, dplEllipseOf(p).radiusYPx, push.heightPx) + v * push.rows;
            do {
                table[first + rows.x * runs] += one;
                ++rows.x;
            } while (rows.x <= rows.y);
        }
    }
}
