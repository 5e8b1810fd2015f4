// SPDX-License-Identifier: Apache-2.0
// Counts the entries of each tile: [row][column][segment]. kTileSegments lanes share the spans of a row in equal parts, in order.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/pairs.glsl"
layout(local_size_x = 32) in;  // kRunGroup

DPL_PAIRS(0, SpanBlock, spans);  // TileSpan
DPL_WORDS(1, SumBlock, sums);
layout(std430, binding = 2) buffer TableBlock { uint table[]; };  // zero before this pass
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/segment.glsl"

void main() {
    uint row = gl_GlobalInvocationID.x / kTileSegments, segment = gl_GlobalInvocationID.x % kTileSegments;
    if (row >= push.viewCount * push.rows) return;
    uint first = push.firstTileTable + row * push.columns * kTileSegments + segment, end;
    uint i = dplSegment(row, segment, end);
    if (i >= end) return;
    uint columns = dplTileSpan(DPL_PAIR(spans, i)).columns, column = dplFirstColumn(columns);
    do {  // one column in each round, because neighbouring lanes have spans of different lengths
        table[first + column * kTileSegments]++;
        bool last = column >= dplLastColumn(columns);
        i += last ? 1u : 0u;
        columns = dplTileSpan(DPL_PAIR(spans, min(i, end - 1u))).columns;
        column = last ? dplFirstColumn(columns) : column + 1u;
    } while (i < end);
}
