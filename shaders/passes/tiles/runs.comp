// SPDX-License-Identifier: Apache-2.0
// Counts the spans of each run in each row of tiles: [row][run]. A run is kRun neighbours of the sorted list.
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
layout(std430, binding = 3) writeonly buffer TableBlock { uint table[]; };
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/tiles.glsl"

#define DPL_LISTS kMostTiles
#include "shaders/lib/tally.glsl"

void main() {
    uint run = gl_WorkGroupID.x, end = min((run + 1u) * kRun, counts.visible);
    for (uint v = 0u; v < kViews; ++v) {
        if (v > 0u) barrier();  // the counts of the view before are in use
        dplClearTally(push.rows);
        for (uint i = run * kRun + gl_LocalInvocationIndex; i < end; i += kRunGroup) {
            ProjectedSplat p = dplRecord(v * push.splatCount + DPL_WORD(order, i));
            uvec2 rows = dplRowsOf(p, dplEllipseOf(p));
            for (uint row = rows.x; row <= rows.y; ++row) atomicAdd(dplTally[row], 1u);
        }
        barrier();
        for (uint row = gl_LocalInvocationIndex; row < push.rows; row += kRunGroup)
            table[push.firstRunTable + (v * push.rows + row) * counts.runs + run] = dplTally[row];
    }
}
