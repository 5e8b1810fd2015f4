// SPDX-License-Identifier: Apache-2.0
// Counts the entries of each tile: [row][column][segment]. A workgroup counts one segment of a row.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/pairs.glsl"
layout(local_size_x = 32) in;  // kRunGroup

DPL_PAIRS(0, SpanBlock, spans);  // TileSpan
DPL_WORDS(1, SumBlock, sums);
layout(std430, binding = 2) writeonly buffer TableBlock { uint table[]; };
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/segment.glsl"

#define DPL_LISTS kMostTiles
#include "shaders/lib/tally.glsl"

void main() {
    uint row = gl_WorkGroupID.x / kTileSegments, segment = gl_WorkGroupID.x % kTileSegments, end;
    dplClearTally(push.columns);
    for (uint i = dplSegment(row, segment, end) + gl_LocalInvocationIndex; i < end; i += kRunGroup) {
        uint columns = dplTileSpan(DPL_PAIR(spans, i)).columns;
        for (uint column = dplFirstColumn(columns); column <= dplLastColumn(columns); ++column) atomicAdd(dplTally[column], 1u);
    }
    barrier();
    for (uint column = gl_LocalInvocationIndex; column < push.columns; column += kRunGroup)
        table[push.firstTileTable + (row * push.columns + column) * kTileSegments + segment] = dplTally[column];
}
