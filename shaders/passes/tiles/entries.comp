// SPDX-License-Identifier: Apache-2.0
// Writes the record numbers of each tile's splats, nearest first. A workgroup writes those of one segment of a row. Afterwards the places
// hold the end of each segment.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shaders/shared/frame.h"
#include "shaders/lib/reads.glsl"
#include "shaders/lib/pairs.glsl"
layout(local_size_x = 32) in;  // kRunGroup

DPL_PAIRS(0, SpanBlock, spans);  // TileSpan
DPL_WORDS(1, SumBlock, sums);
layout(std430, binding = 2) buffer PlaceBlock { uint places[]; };
layout(std430, binding = 3) writeonly buffer EntryBlock { uint entries[]; };
layout(push_constant) uniform PushBlock { TilePush push; };
#include "shaders/lib/segment.glsl"

#define DPL_LISTS kMostTiles
#include "shaders/lib/ranks.glsl"

void main() {
    uint row = gl_WorkGroupID.x / kTileSegments, segment = gl_WorkGroupID.x % kTileSegments, end;
    uint cells = push.firstTileTable + row * push.columns * kTileSegments + segment;
    for (uint column = gl_LocalInvocationIndex; column < push.columns; column += kRunGroup)
        dplStartList(column, places[cells + column * kTileSegments]);
    barrier();
    for (uint first = dplSegment(row, segment, end); first < end; first += kRunGroup) {
        uint i = first + gl_LocalInvocationIndex;
        TileSpan span = dplTileSpan(i < end ? DPL_PAIR(spans, i) : uvec2(0u, 1u));  // past the end: from column 1 to 0
        uint from = dplFirstColumn(span.columns), to = dplLastColumn(span.columns);
        for (uint column = from; column <= to; ++column) dplJoin(column);
        barrier();
        for (uint column = from; column <= to; ++column) entries[dplPlaceIn(column)] = span.record;
        barrier();
        for (uint column = from; column <= to; ++column) dplLeave(column);
    }
    barrier();
    for (uint column = gl_LocalInvocationIndex; column < push.columns; column += kRunGroup)
        places[cells + column * kTileSegments] = dplEnds[column];
}
